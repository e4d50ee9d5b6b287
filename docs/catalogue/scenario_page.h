#pragma once

#include <filesystem>
#include <string>

namespace tenon::docs {

/// Returns the text of docs/keys/meanings.yaml: the docstring of each member of the scenarios' structs, by
/// struct and key, read from the source tree at `source`.
std::string WriteMeanings(const std::filesystem::path& source);

/// Returns the text of docs/scenarios.md: all keys of the scenarios of all apps.
std::string WriteScenarioKeys();

}  // namespace tenon::docs
