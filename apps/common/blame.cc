#include <tenon/apps/common/blame.h>

#include <fmt/core.h>

namespace tenon::apps {

int RunBlaming(const YamlDocument& scenario, const std::function<int()>& run) {
  try {
    return run();
  } catch (const KeyError& error) {
    const std::string place = error.key().empty() ? scenario.name() : scenario.PlaceOf(error.key());
    throw ParameterError(fmt::format("{}: {}", place, error.what()));
  }
}

}  // namespace tenon::apps
