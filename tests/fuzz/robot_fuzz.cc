// Text as the YAML file of a quadruped or, if it has cables, of a cable robot.

#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/fuzz/refusals.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tenon::fuzz::Scratch kScratch;
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string file = kScratch.Write("input.yaml", text);
  return tenon::fuzz::Try(kScratch.place(), [&] {
    if (text.find("cables:") != text.npos) {
      tenon::LoadCdpr(file);
    } else {
      tenon::LoadQuadruped(file);
    }
  });
}
