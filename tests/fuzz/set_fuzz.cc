// KEY=VALUE, as --set takes it, on a scenario that ships.

#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/fuzz/refusals.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto kScenario = tenon::YamlDocument::Load(tenon::FindResource("scenarios", "flat"));
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t equals = std::min(text.find('='), text.size());
  return tenon::fuzz::Try("--set ", [&] {
    auto document = kScenario;
    document.Set(text.substr(0, equals), text.substr(std::min(equals + 1, text.size())));
    document.Read<tenon::apps::QuadrupedScenario>();
  });
}
