// Text as a scenario: of the app that it names, or of each.

#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/guide_dog/guide_dog_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/tests/fuzz/refusals.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  return tenon::fuzz::Try("input.yaml:", [&] {
    const auto document = tenon::YamlDocument::Parse(text, "input.yaml");
    const std::string app = document.Text("app");
    if (app == "tenon-cdpr") {
      document.Read<tenon::apps::CdprScenario>();
    } else if (app == "tenon-guide-dog") {
      document.Read<tenon::apps::GuideDogScenario>();
    } else {
      document.Read<tenon::apps::QuadrupedScenario>();
    }
  });
}
