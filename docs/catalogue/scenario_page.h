#pragma once

#include <filesystem>
#include <string>

namespace tenon::docs {

/// docs/keys/meanings.yaml: what the members of scenarios' structs mean, by struct and key, as the docstrings
/// in the source tree at `source` tell it.
std::string WriteMeanings(const std::filesystem::path& source);

/// docs/scenarios.md: all keys of the scenarios of all apps.
std::string WriteScenarioKeys();

}  // namespace tenon::docs
