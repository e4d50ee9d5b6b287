// Text as the URDF of a robot that ships.

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/fuzz/refusals.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tenon::fuzz::Scratch kScratch;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const bool is_a1 = text.find("\"FL_foot\"") != text.npos;
  kScratch.Write(is_a1 ? "a1.urdf" : "dogbot.urdf", text);
  return tenon::fuzz::Try(kScratch.place(), [&] {
    tenon::LoadQuadruped(kScratch.place() + (is_a1 ? "/a1.yaml" : "/dogbot.yaml"));
  });
}
