#pragma once

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>

namespace tenon::test {

/// A path in the temporary directory where nothing is yet, and no other process writes: tests run at once.
/// Who writes there removes it.
inline std::filesystem::path TemporaryPath(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');  // of a test with parameters
  auto path = std::filesystem::temp_directory_path() / (std::to_string(getpid()) + "_" + name);
  std::filesystem::remove_all(path);
  return path;
}

}  // namespace tenon::test
