#pragma once

#include <tenon/systems/yaml/resources.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace tenon::fuzz {

/// A directory of this process with the robots that ship in it.
class Scratch {
 public:
  Scratch() : place_(std::filesystem::temp_directory_path() / ("tenon_fuzz_" + std::to_string(::getpid()))) {
    using std::filesystem::copy_options;
    std::filesystem::copy(DataDirectory() / "robots", place_,
                          copy_options::recursive | copy_options::overwrite_existing);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(place_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  std::string place() const { return place_.string(); }
  std::string Write(const std::string& name, const std::string& text) const {
    const std::filesystem::path file = place_ / name;
    std::ofstream out(file, std::ios::binary);
    if (!(out << text).flush()) std::abort();  // otherwise a file that is missing would count as refused
    return file.string();
  }

 private:
  std::filesystem::path place_;
};

}  // namespace tenon::fuzz
