#include <tenon/apps/common/blame.h>
#include <tenon/systems/yaml/resources.h>

#include <string_view>
#include <vector>

namespace tenon::apps {

/// Returns the key called `name` in the outermost map that has one; empty if there is none.
static std::string FindKey(const YamlDocument& scenario, std::string_view name) {
  std::vector<std::string> paths = scenario.Keys("");
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::string path = paths[i];
    if (path.substr(path.rfind('.') + 1) == name) return path;
    for (const std::string& key : scenario.Keys(path)) paths.push_back(path + "." + key);
  }
  return {};
}

/// Returns the key called like a block, or like the innermost diagram around it that has a key.
static std::string KeyOfBlock(const YamlDocument& scenario, std::string_view path) {
  while (!path.empty()) {
    const std::size_t dot = path.rfind('.');
    if (std::string key = FindKey(scenario, path.substr(dot + 1)); !key.empty()) return key;
    path = path.substr(0, dot == path.npos ? 0 : dot);
  }
  return {};
}

/// Removes the place in a ResourceMap from a message, because that map is part of the scenario.
static std::string_view WithoutPlaceInMap(std::string_view message) {
  if (!message.starts_with(kChanges)) return message;
  const std::size_t end = message.find(": ");
  return end == message.npos ? message : message.substr(end + 2);
}

void ThrowWithPlace(const YamlDocument& scenario, const KeyError& error) {
  const std::string key = error.key().empty() ? KeyOfBlock(scenario, error.block()) : error.key();
  throw ParameterError(scenario.Placed(key, WithoutPlaceInMap(error.what())));
}

}  // namespace tenon::apps
