#include <tenon/apps/common/blame.h>

#include <fmt/core.h>

namespace tenon::apps {

int RunBlaming(const YamlDocument& scenario, const std::function<int()>& run) {
  try {
    return run();
  } catch (const KeyError& error) {
    throw ParameterError(fmt::format("{}: {}", scenario.PlaceOf(error.key()), error.what()));
  } catch (const ParameterError& error) {
    throw ParameterError(fmt::format("{}: {}", scenario.name(), error.what()));
  }
}

}  // namespace tenon::apps
