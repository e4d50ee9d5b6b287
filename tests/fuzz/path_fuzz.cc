// Text as the CSV file of a path.

#include <tenon/apps/cdpr/path_file.h>
#include <tenon/tests/fuzz/refusals.h>
#include <tenon/tests/fuzz/scratch.h>

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tenon::fuzz::Scratch kScratch;
  const std::string file = kScratch.Write("path.csv", {reinterpret_cast<const char*>(data), size});
  return tenon::fuzz::Try(file, [&] { tenon::apps::ReadPathFile(file); });
}
