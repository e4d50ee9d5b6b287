#pragma once

#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/yaml/yaml.h>

#include <string>
#include <utility>

namespace tenon::apps {

/// An error in the value of a scenario's key that was found after the scenario was read. An empty key stands
/// for the key called like the error's block, or for the whole scenario.
class KeyError : public ParameterError {
 public:
  KeyError(std::string key, const std::string& what) : ParameterError(what), key_(std::move(key)) {}
  KeyError(std::string key, const ParameterError& error) : ParameterError(error), key_(std::move(key)) {}
  const std::string& key() const { return key_; }

 private:
  std::string key_;
};

/// Returns make(). Rethrows a ParameterError as a KeyError of `key`.
template <class F>
decltype(auto) Blame(const std::string& key, F make) {
  try {
    return make();
  } catch (const KeyError&) {
    throw;  // names a more precise key
  } catch (const ParameterError& error) {
    throw KeyError(key, error);
  }
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
