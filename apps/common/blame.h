#pragma once

#include <span>
#include <string>
#include <utility>

#include <tenon/systems/framework/errors.h>
#include <tenon/systems/yaml/yaml.h>

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

/// What `make` gives; what it refuses is the fault of what stands under `key`.
template <class F>
decltype(auto) Blame(const std::string& key, F make) {
  try {
    return make();
  } catch (const KeyError&) {
    throw;  // knows better
  } catch (const ParameterError& error) {
    throw KeyError(key, error.what());
  }
}

/// The key of a scenario from which a block has its parameters.
struct KeyOfBlock {
  const char* block;
  const char* key;
};

/// What `make` gives, which adds a diagram to a builder; what a block refuses is the fault of its key, of the
/// first in the list that the message names.
template <class F>
decltype(auto) BlameBlocks(std::span<const KeyOfBlock> keys, F make) {
  try {
    return make();
  } catch (const KeyError&) {
    throw;
  } catch (const ParameterError& error) {
    for (const auto& [block, key] : keys)
      if (std::string(error.what()).find("block '" + std::string(block) + "'") != std::string::npos)
        throw KeyError(key, error.what());
    throw KeyError("", error.what());
  }
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
