#pragma once

#include <tenon/systems/files/input_file.h>

#include <unistd.h>

#include <algorithm>
#include <sstream>

namespace tenon::test {

/// A path in the temporary directory where no file exists and no other process writes: tests may run at the
/// same time. The caller removes what it writes.
inline std::filesystem::path TemporaryPath(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');  // of a test with parameters
  auto path = std::filesystem::temp_directory_path() / (std::to_string(getpid()) + "_" + name);
  std::filesystem::remove_all(path);
  return path;
}

}  // namespace tenon::test
