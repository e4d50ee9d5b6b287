#pragma once

#include <tenon/systems/yaml/yaml.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tenon::apps {

/// Sets values of a document by key=value, as --set gives them. Throws ParameterError.
void ApplySettings(const std::vector<std::string>& settings, YamlDocument* document);

/// A scenario, shipped or a file, with all `settings`, key=value, applied. `extends: NAME` in a scenario
/// takes over everything of another that it does not say itself; lists are taken over as a whole. Throws
/// ParameterError, among others for a scenario of another app than `app`.
YamlDocument LoadScenario(const std::string& name, const std::vector<std::string>& settings,
                          const std::string& app);

/// Gives a scenario its seed, if there is one, and draws what it leaves to chance. Returns what was drawn.
std::vector<std::pair<std::string, double>> DrawScenario(YamlDocument& scenario,
                                                         std::optional<std::uint64_t> seed);

/// Names and descriptions of the shipped scenarios whose `app` key is this app's name.
std::vector<std::pair<std::string, std::string>> ListScenarios(const std::string& app);

/// scenario.yaml of a run, with the files that it names and that do not ship: wherever they are copied to,
/// the run can be repeated from there.
class ScenarioFiles {
 public:
  /// Reads the files that the YamlFiles in the scenario name. Throws ParameterError.
  template <HasFields T>
  explicit ScenarioFiles(T scenario) {
    Take(internal::TypeInfoOf<T>(), &scenario);
  }
  /// Writes scenario.yaml, and the files that it names into `files` beside it; what an earlier run wrote in
  /// there goes, and nothing else. Throws OutputError.
  void Write(const std::filesystem::path& directory) const;

 private:
  void Take(const internal::TypeInfo& type, void* scenario);
  void Take(const std::string& key, YamlFile& file);

  std::string text_;
  std::vector<std::pair<std::string, std::string>> files_;  ///< names, contents
};

}  // namespace tenon::apps
