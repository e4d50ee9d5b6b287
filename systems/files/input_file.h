#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

namespace tenon {

/// Opens a regular file for reading. The stream is not open if the path names anything else, or nothing:
/// opening a pipe waits for a writer, and a device can be endless.
inline std::ifstream OpenInput(const std::filesystem::path& file, std::ios::openmode mode = {}) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return {};
  return std::ifstream(file, mode | std::ios::in);
}

/// Returns the contents of a regular file, empty if it cannot be read.
inline std::string ReadText(const std::filesystem::path& file) {
  std::ifstream in = OpenInput(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace tenon
