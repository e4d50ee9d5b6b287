#include <tenon/apps/common/customisation.h>

#include <fmt/format.h>

#include <set>

namespace tenon::apps {

void RefuseCustomKeys(const std::optional<YamlText>& custom) {
  if (custom)
    throw KeyError(
        "custom",
        "only a program with blocks of its own has keys here: run that program, or remove `custom`");
}

std::vector<const System*> BlocksOf(const Subdiagram& diagram) {
  std::vector<const System*> blocks;
  for (const auto& block : diagram.blocks()) {
    blocks.push_back(block.get());
    if (const auto* nested = dynamic_cast<const Subdiagram*>(block.get()))
      for (const System* inner : BlocksOf(*nested)) blocks.push_back(inner);
  }
  return blocks;
}

void SayOnce(const std::string& text) {
  static std::mutex mutex;
  static std::set<std::string> said;
  const std::lock_guard lock(mutex);
  if (said.insert(text).second) Say(text);
}

void SayDropped(const std::vector<const System*>& shipped) {
  for (const System* block : shipped) {
    if (block->replaced_by() == nullptr) continue;
    std::vector<std::string> inputs;
    for (const Source* input : block->sources())
      if (input->kind() == SourceKind::kInput && input->driver() != nullptr && FindCurrent(*input) == nullptr)
        inputs.push_back(fmt::format("'{}' ({})", input->name(), input->type_name()));
    if (inputs.empty()) continue;
    SayOnce(fmt::format("note: your block '{}' has no input {}, to which the shipped one is connected\n",
                        block->path(), fmt::join(inputs, ", ")));
  }
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
