#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tenon {

class YamlDocument;
struct YamlText;

/// The file of a robot or a scenario: `FindResource("robots", "cdpr_4")` is the file that ships with Tenon
/// under that name; a name that ends in .yaml or holds a slash is a path and is returned as it is. Throws
/// ParameterError with the names that there are, the nearest first.
std::filesystem::path FindResource(const std::string& kind, const std::string& name);

/// What a scenario says for a resource: a name or a path as above, or a map that says which file, and what is
/// different in it, `{file: standard, observer: {ndo_gain: 5}}`. Throws ParameterError.
YamlDocument LoadResource(const std::string& kind, const YamlText& what);

/// Names of all shipped resources of a kind, sorted.
std::vector<std::string> ListResources(const std::string& kind);

/// Where robots and scenarios are installed: the directory in the environment variable TENON_DATA_DIR, else
/// share/tenon beside the library, else the build tree's.
std::filesystem::path DataDirectory();

}  // namespace tenon
