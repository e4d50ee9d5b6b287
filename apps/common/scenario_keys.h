#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>
#include <tenon/systems/yaml/yaml.h>

#include <string>
#include <vector>

namespace tenon::apps {

/// A key of a scenario.
struct ScenarioKey {
  std::string key;      ///< dotted; [] stands for the items of a list: forces[].duration_s
  std::string type;     ///< number, integer, text, list of 3 numbers, one of on, off, …
  std::string unit;     ///< as its name says it: m/s
  std::string initial;  ///< what it is if a scenario does not say; "required" if it has to
  std::string meaning;  ///< empty where nobody told
};

/// All keys of a struct, those of its structs after them, with the values that `value` has. The meanings are
/// those that its members have in the headers of Tenon, kept in share/tenon/keys.
std::vector<ScenarioKey> KeysOf(const internal::TypeInfo& type, const void* value);
template <HasFields T>
std::vector<ScenarioKey> KeysOf() {
  const T value{};
  return KeysOf(internal::TypeInfoOf<T>(), &value);
}

/// The keys of a shipped file, or of one of a path, that a scenario names under `key`, with their values
/// there; none of the word `none`. Throws ParameterError.
std::vector<ScenarioKey> KeysOfFile(const std::string& kind, const YamlFile& what, const std::string& key);

/// The name of a struct, without namespaces and arguments of templates.
std::string StructName(const internal::TypeInfo& type);

/// On stdout, a line for each key.
void PrintKeys(const std::vector<ScenarioKey>& keys);

}  // namespace tenon::apps
