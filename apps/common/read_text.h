#pragma once

#include <tenon/systems/files/input_file.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace tenon::apps {

/// Returns the contents of a regular file, empty if it cannot be read.
inline std::string ReadText(const std::filesystem::path& file) {
  std::ifstream in = OpenInput(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace tenon::apps
