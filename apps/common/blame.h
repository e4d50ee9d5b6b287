#pragma once

#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/yaml/yaml.h>

#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace tenon::apps {

/// What a scenario says under a key cannot be had; found after the scenario was read. An empty key is the
/// scenario as a whole.
class KeyError : public ParameterError {
 public:
  KeyError(std::string key, const std::string& what) : ParameterError(what), key_(std::move(key)) {}
  const std::string& key() const { return key_; }

 private:
  std::string key_;
};

/// What `make` gives; what it refuses is the fault of the key that `key_of(message)` says.
template <class F>
decltype(auto) BlameBy(const auto& key_of, F make) {
  try {
    return make();
  } catch (const KeyError&) {
    throw;  // knows better
  } catch (const ParameterError& error) {
    throw KeyError(key_of(error.what()), error.what());
  }
}

/// What `make` gives; what it refuses is the fault of what stands under `key`.
template <class F>
decltype(auto) Blame(const std::string& key, F make) {
  return BlameBy([&](const char*) { return key; }, std::move(make));
}

/// The key of a scenario from which a block has its parameters.
struct KeyOfBlock {
  const char* block;
  const char* key;
};

/// The key of the first in the list that a message names; empty if it names none.
std::string KeyOfBlockIn(std::string_view message, std::span<const KeyOfBlock> keys);

/// What `make` gives, which adds a diagram to a builder; what a block refuses is the fault of its key.
template <class F>
decltype(auto) BlameBlocks(std::span<const KeyOfBlock> keys, F make) {
  return BlameBy([&](std::string_view message) { return KeyOfBlockIn(message, keys); }, std::move(make));
}

/// The error of a key with file, line and column.
[[noreturn]] void ThrowWithPlace(const YamlDocument& scenario, const KeyError& error);

/// What `run` gives, which does what a scenario asks for. A KeyError is thrown with file, line and column of
/// the key; what has none, and may be the command line's, as it is.
template <class F>
auto RunBlaming(const YamlDocument& scenario, F run) {
  try {
    return run();
  } catch (const KeyError& error) {
    ThrowWithPlace(scenario, error);
  }
}

}  // namespace tenon::apps
