#pragma once

#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/yaml/resources.h>

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

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

/// Runs `call` on an input. It may be refused; what else is thrown is not caught and ends the fuzzer, and so
/// does a refusal that does not name the place: `place` has to be in its text.
template <class Call>
int Try(std::string_view place, const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    if (std::string_view(error.what()).find(place) != std::string_view::npos) return 0;
    std::fprintf(stderr, "a refusal without '%.*s': %s\n", static_cast<int>(place.size()), place.data(),
                 error.what());
    std::abort();
  }
  return 0;
}

/// Writes the input to the file `name` and runs `call` on it, see Try.
template <class Call>
int TryFile(const char* name, const std::uint8_t* data, std::size_t size, const Call& call) {
  static const Scratch kScratch;
  const std::string file = kScratch.Write(name, {reinterpret_cast<const char*>(data), size});
  return Try(file, [&] { call(file); });
}

}  // namespace tenon::fuzz
