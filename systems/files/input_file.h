#pragma once

#include <filesystem>
#include <fstream>
#include <system_error>

namespace tenon {

/// Opens a regular file for reading. The stream is not open if the path names anything else, or nothing:
/// opening a pipe waits for a writer, and a device can be endless.
inline std::ifstream OpenInput(const std::filesystem::path& file, std::ios::openmode mode = {}) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return {};
  return std::ifstream(file, mode | std::ios::in);
}

}  // namespace tenon
