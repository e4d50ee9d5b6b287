#pragma once

#include <tenon/systems/yaml/yaml.h>

#include <filesystem>

namespace tenon::apps {

/// Sets values of a document by the key=value texts of --set. Throws ParameterError.
void ApplySettings(const std::vector<std::string>& settings, YamlDocument* document);

/// Loads a shipped scenario or a file and applies the key=value texts of `settings`. A scenario with
/// `extends: NAME` inherits all keys of another scenario that it does not set itself; lists are inherited as
/// a whole. If `files` is given, it receives the paths of all files that were read. Throws ParameterError,
/// also for a scenario of another app than `app`, if `app` is not empty.
YamlDocument LoadScenario(const std::string& name, const std::vector<std::string>& settings,
                          const std::string& app, std::vector<std::string>* files = nullptr);

/// Sets the seed of a scenario, if one is given, and draws its random values. Returns the drawn values by
/// key.
std::vector<std::pair<std::string, double>> DrawScenario(YamlDocument& scenario,
                                                         std::optional<std::uint64_t> seed);

/// Returns names and descriptions of the shipped scenarios of an app.
std::vector<std::pair<std::string, std::string>> ListScenarios(const std::string& app);

/// The scenario.yaml of a run and copies of the files that it names, except shipped ones. The run can be
/// repeated from these files alone, also after they are moved.
class ScenarioFiles {
 public:
  /// Reads the files that the YamlFiles in the scenario name. Throws ParameterError.
  template <HasFields T>
  explicit ScenarioFiles(T scenario) {
    Take(internal::TypeInfoOf<T>(), &scenario);
  }
  /// Writes scenario.yaml, and the files that it names into the subdirectory `files`, from which it removes
  /// only files of an earlier run. Throws OutputError.
  void Write(const std::filesystem::path& directory) const;

 private:
  void Take(const internal::TypeInfo& type, void* scenario);
  void Take(const std::string& key, YamlFile& file);

  std::string text_;
  std::vector<std::pair<std::string, std::string>> files_;  ///< names and contents
};

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
