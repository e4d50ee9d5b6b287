#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tenon {

/// What errors call a ResourceMap, in place of a file: "what differs:1:20: mass_kg: …".
inline constexpr const char* kWhatDiffers = "what differs";

class YamlDocument;
struct YamlFile;

/// Whether a name is the path of a file: it ends in .yaml or holds a slash.
bool IsResourcePath(const std::string& name);
/// The file of a robot or a scenario: `FindResource("robots", "cdpr_4")` is the file that ships with Tenon
/// under that name; a path is returned as it is. Throws ParameterError with the names that there are, the
/// nearest first.
std::filesystem::path FindResource(const std::string& kind, const std::string& name);
/// The same with the names that may be meant.
std::filesystem::path FindResource(const std::string& kind, const std::string& name,
                                   const std::vector<std::string>& names);

/// The file that a scenario names, with what it says to be different there. Throws ParameterError.
YamlDocument LoadResource(const std::string& kind, const YamlFile& what);
/// The same where only files with `key` at top level are meant: "urdf" of the robots that walk, say.
YamlDocument LoadResource(const std::string& kind, const YamlFile& what, const std::string& key);
/// The same as a map in any case, `{file: standard}`; nothing is read.
YamlDocument ResourceMap(const YamlFile& what);
/// What a run calls that file: its name, or its path; of one with differences, "cdpr_4, changed".
std::string ResourceName(const YamlFile& what);

/// Names of all shipped resources of a kind, sorted.
std::vector<std::string> ListResources(const std::string& kind);
/// Those whose files have `key` at top level.
std::vector<std::string> ListResources(const std::string& kind, const std::string& key);

/// Where robots and scenarios are installed: the directory in the environment variable TENON_DATA_DIR, else
/// share/tenon beside the library, else the build tree's.
std::filesystem::path DataDirectory();

}  // namespace tenon
