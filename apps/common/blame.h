#pragma once

#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/yaml/yaml.h>

#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace tenon::apps {

/// An error in the value of a scenario's key that was found after the scenario was read. An empty key stands
/// for the whole scenario.
class KeyError : public ParameterError {
 public:
  KeyError(std::string key, const std::string& what) : ParameterError(what), key_(std::move(key)) {}
  const std::string& key() const { return key_; }

 private:
  std::string key_;
};

/// Returns make(). Rethrows a ParameterError as a KeyError of the key `key_of(error)`.
template <class F>
decltype(auto) BlameBy(const auto& key_of, F make) {
  try {
    return make();
  } catch (const KeyError&) {
    throw;  // names a more precise key
  } catch (const ParameterError& error) {
    throw KeyError(key_of(error), error.what());
  }
}

/// Returns make(). Rethrows a ParameterError as a KeyError of `key`.
template <class F>
decltype(auto) Blame(const std::string& key, F make) {
  return BlameBy([&](const ParameterError&) { return key; }, std::move(make));
}

/// A block and the key of the scenario that sets its parameters.
struct KeyOfBlock {
  const char* block;
  const char* key;
};

/// Returns the key of the first entry whose block is, or contains, the one with this path; empty if there is
/// none.
std::string KeyOfBlockAt(std::string_view path, std::span<const KeyOfBlock> keys);

/// Returns make(), which adds a diagram to a builder. Rethrows the ParameterError of a block as a KeyError of
/// the block's key.
template <class F>
decltype(auto) BlameBlocks(std::span<const KeyOfBlock> keys, F make) {
  return BlameBy([&](const ParameterError& error) { return KeyOfBlockAt(error.block(), keys); },
                 std::move(make));
}

/// Throws the error with file, line and column of its key.
[[noreturn]] void ThrowWithPlace(const YamlDocument& scenario, const KeyError& error);

/// Returns run(), which runs a scenario. Rethrows a KeyError as a ParameterError with file, line and column
/// of the key.
template <class F>
auto RunBlaming(const YamlDocument& scenario, F run) {
  try {
    return run();
  } catch (const KeyError& error) {
    ThrowWithPlace(scenario, error);
  }
}

}  // namespace tenon::apps
