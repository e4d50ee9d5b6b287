#include <tenon/apps/common/blame.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {

std::string KeyOfBlockAt(std::string_view path, std::span<const KeyOfBlock> keys) {
  const std::string dotted = fmt::format(".{}.", path);
  for (const auto& [block, key] : keys)
    if (dotted.find(fmt::format(".{}.", block)) != dotted.npos) return key;
  return {};
}

/// Removes the place in a ResourceMap from a message, because that map is part of the scenario.
static std::string_view WithoutPlaceInMap(std::string_view message) {
  if (!message.starts_with(kChanges)) return message;
  const std::size_t end = message.find(": ");
  return end == message.npos ? message : message.substr(end + 2);
}

void ThrowWithPlace(const YamlDocument& scenario, const KeyError& error) {
  throw ParameterError(scenario.Placed(error.key(), WithoutPlaceInMap(error.what())));
}

}  // namespace tenon::apps
