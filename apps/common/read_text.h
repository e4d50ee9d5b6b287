#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace tenon::apps {

/// Returns the contents of a file, empty if it cannot be read.
inline std::string ReadText(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace tenon::apps
