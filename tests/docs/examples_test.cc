// The programs that pages show are those that ship in docs/examples, where they are compiled and run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace tenon::docs::examples_test {
namespace {

std::string Read(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(std::filesystem::path(TENON_SOURCE_DIR) / file).rdbuf();
  return text.str();
}

TEST(ExamplesTest, TheProgramOfTheReadmeShips) {
  EXPECT_THAT(Read("README.md"),
              ::testing::HasSubstr("```cpp\n" + Read("docs/examples/first/main.cc") + "```"));
}

TEST(ExamplesTest, TheFilesOfTheTutorialShip) {
  const std::string page = Read("docs/tutorial.md");
  for (const std::string name :
       {"CMakeLists.txt", "momentum_observer.h", "momentum_observer_test.cc", "main.cc"}) {
    const std::string kind = name == "CMakeLists.txt" ? "cmake" : "cpp";
    EXPECT_THAT(page, ::testing::HasSubstr("`" + name + "`:\n\n```" + kind + "\n" +
                                           Read("docs/examples/tutorial/" + name) + "```"));
  }
}

TEST(ExamplesTest, TheProgramOfThePythonPageShips) {
  EXPECT_THAT(Read("docs/python.md"),
              ::testing::HasSubstr("```python\n" + Read("docs/examples/python/payload.py") + "```"));
}

}  // namespace
}  // namespace tenon::docs::examples_test
