#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

/// Runs a program of the PATH without a shell. Returns its exit code, or nothing if it is not installed.
/// Throws OutputError if it cannot be started.
std::optional<int> RunProgram(std::vector<std::string> arguments);

}  // namespace tenon::apps
