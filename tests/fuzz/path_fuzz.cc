// Text as the CSV file of a path.

#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/tests/fuzz/refusals.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return tenon::fuzz::TryFile("path.csv", data, size,
                              [](const std::string& file) { tenon::apps::ReadPathFile(file); });
}
