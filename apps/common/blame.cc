#include <tenon/apps/common/blame.h>

#include <fmt/core.h>

namespace tenon::apps {

void ThrowWithPlace(const YamlDocument& scenario, const KeyError& error) {
  const std::string place = error.key().empty() ? scenario.name() : scenario.PlaceOf(error.key());
  throw ParameterError(fmt::format("{}: {}", place, error.what()));
}

}  // namespace tenon::apps
