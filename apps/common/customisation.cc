#include <tenon/apps/common/customisation.h>

#include <algorithm>

namespace tenon::apps {

void RefuseCustomKeys(const std::optional<YamlText>& custom) {
  if (custom)
    throw KeyError(
        "custom",
        "only a program with blocks of its own has keys here: run that program, or remove `custom`");
}

std::vector<ScenarioKey> WithCustomKeys(std::vector<ScenarioKey> keys, std::vector<ScenarioKey> own) {
  std::erase_if(keys, [](const ScenarioKey& key) { return key.key == "custom"; });
  for (ScenarioKey& key : own) {
    key.key = "custom." + key.key;
    keys.push_back(std::move(key));
  }
  return keys;
}

}  // namespace tenon::apps
