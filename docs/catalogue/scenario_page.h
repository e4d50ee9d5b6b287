#pragma once

#include <filesystem>
#include <string>

namespace tenon::docs {

/// The text of docs/keys/meanings.yaml: the meanings of the keys of scenarios, by struct and key, from the
/// docstrings in the source tree at `source`.
std::string WriteMeanings(const std::filesystem::path& source);

/// The text of docs/scenarios.md: all keys of the scenarios of all apps.
std::string WriteScenarioKeys();

}  // namespace tenon::docs
