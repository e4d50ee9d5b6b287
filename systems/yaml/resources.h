#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tenon {

/// The name of a ResourceMap in errors, in place of a file: "changes:1:20: mass_kg: …".
inline constexpr const char* kChanges = "changes";

class YamlDocument;
struct YamlFile;

/// Returns whether a name is the path of a file: it ends in .yaml or holds a slash.
bool IsResourcePath(const std::string& name);
/// Returns the path of a resource: `FindResource("robots", "cdpr_4")` is the file that ships with Tenon under
/// that name; a path is returned unchanged. Throws ParameterError with the available and the nearest names.
std::filesystem::path FindResource(const std::string& kind, const std::string& name);
/// Finds a resource among `names` only.
std::filesystem::path FindResource(const std::string& kind, const std::string& name,
                                   const std::vector<std::string>& names);

/// Loads the file that a scenario names and applies the changes to it that the scenario gives. If `key` is
/// not empty, a shipped file must have that key at top level: "urdf" of the robots that walk, say. Throws
/// ParameterError.
YamlDocument LoadResource(const std::string& kind, const YamlFile& what, const std::string& key = "");
/// Returns a resource as a map, `{file: standard}` if the scenario gives only a name. Reads no file.
YamlDocument ResourceMap(const YamlFile& what);
/// The name of a resource in titles: its name or path; if the scenario changes it, "cdpr_4, changed".
std::string ResourceName(const YamlFile& what);

/// Names of all shipped resources of a kind, sorted.
std::vector<std::string> ListResources(const std::string& kind);
/// Names of the shipped resources of a kind whose files have `key` at top level. Reads all of them.
std::vector<std::string> ListResources(const std::string& kind, const std::string& key);

/// The directory of the shipped resources: the environment variable TENON_DATA_DIR, else share/tenon beside
/// the library, else the one in the build tree.
std::filesystem::path DataDirectory();

}  // namespace tenon
