#pragma once

#include <tenon/systems/yaml/yaml.h>

namespace tenon::apps {

/// A key of a scenario, for --keys.
struct ScenarioKey {
  std::string key;      ///< dotted, with [] for items of a list: forces[].duration_s
  std::string type;     ///< number, integer, text, list of 3 numbers, one of on, off, …
  std::string unit;     ///< unit from the key's suffix: m/s
  std::string range;    ///< allowed numbers: above 0, from 0 to 1; empty if all are
  std::string initial;  ///< the default; "required" without one
  std::string meaning;  ///< may be empty
};

/// Lists all keys of a struct and of the structs in it, with the values in `value` as defaults. The meanings
/// are the comments of the members in Tenon's headers, collected in share/tenon/keys.
std::vector<ScenarioKey> KeysOf(const internal::TypeInfo& type, const void* value);
template <HasFields T>
std::vector<ScenarioKey> KeysOf() {
  const T value{};
  return KeysOf(internal::TypeInfoOf<T>(), &value);
}

/// Lists the keys and values of a resource that a scenario names under `key`; empty for the word `none`.
/// Ranges and meanings are those of the keys in `known`, which may be empty. Throws ParameterError.
std::vector<ScenarioKey> KeysOfFile(const std::string& kind, const YamlFile& what, const std::string& key,
                                    const std::vector<ScenarioKey>& known = {});

/// Returns the name of a struct without namespaces and template arguments.
std::string StructName(const std::type_info& type);

/// Prints a line for each key on stdout.
void PrintKeys(const std::vector<ScenarioKey>& keys);

// Ranges of a scenario's numbers.

Range Rates();          ///< valid for Hz(), and at most 100 kHz
Range SamplePeriods();  ///< valid for Seconds(), and at least 10 us
Range Places();         ///< each coordinate within 1 km

}  // namespace tenon::apps
