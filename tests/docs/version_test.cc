// All files that repeat the version of CMakeLists.txt agree with it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace tenon::docs::version_test {

std::string Read(const char* file) {
  std::ostringstream text;
  text << std::ifstream(std::filesystem::path(TENON_SOURCE_DIR) / file).rdbuf();
  return text.str();
}

TEST(VersionTest, IsOneEverywhere) {
  const std::string version = TENON_VERSION;
  EXPECT_THAT(Read("CITATION.cff"), ::testing::HasSubstr("\nversion: " + version + "\n"));
  EXPECT_THAT(Read("CHANGELOG.md"), ::testing::HasSubstr("\n## " + version + "\n"));
  EXPECT_THAT(Read("README.md"),
              ::testing::HasSubstr("`libtenon" + version.substr(0, version.rfind('.')) + "`"));
}

}  // namespace tenon::docs::version_test
