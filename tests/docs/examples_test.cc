// The programs that pages show are those that ship in docs/examples, where they are compiled and run.

#include <tenon/systems/files/input_file.h>
#include <tenon/tests/testing/matchers.h>

#include <gtest/gtest.h>

#include <sstream>
#include <vector>

namespace tenon::docs::examples_test {

std::string Read(const std::string& file) {
  return ReadText(std::filesystem::path(TENON_SOURCE_DIR) / file);
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

TEST(ExamplesTest, TheProgramOfThePredictiveTutorialShips) {
  EXPECT_THAT(Read("docs/predictive_tutorial.md"),
              ::testing::HasSubstr("```cpp\n" + Read("docs/examples/compose/predictive_walk.cc") + "```"));
}

TEST(ExamplesTest, TheProgramOfThePageOnRos2Ships) {
  EXPECT_THAT(Read("docs/ros2.md"),
              ::testing::HasSubstr("```cpp\n" + Read("docs/examples/ros2/main.cc") + "```"));
}

TEST(ExamplesTest, TheBlockOfForeignCodeShips) {
  EXPECT_THAT(Read("docs/foreign_code.md"),
              ::testing::HasSubstr("```cpp\n" + Read("docs/examples/foreign/foreign_filter.h") + "```"));
}

TEST(ExamplesTest, TheFilesOfTheRobotOnRopesShip) {
  const std::string page = Read("docs/limbs.md"), directory = "docs/examples/how_do_i/";
  EXPECT_THAT(page, HasSubstrs("```yaml\n" + Read(directory + "three_ropes.yaml") + "```",
                               "```cpp\n" + Read(directory + "own_ropes.cc") + "```"));
}

/// The text without the blanks at the beginning of its lines.
std::string WithoutIndentation(const std::string& text) {
  std::istringstream lines(text);
  std::string line, all;
  while (std::getline(lines, line)) all += line.erase(0, line.find_first_not_of(' ')) + "\n";
  return all;
}

/// The parts of `text` between `begin` and `end`.
std::vector<std::string> Between(const std::string& text, const std::string& begin, const std::string& end) {
  std::vector<std::string> parts;
  for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    at += begin.size();
    parts.push_back(text.substr(at, text.find(end, at) - at));
  }
  return parts;
}

TEST(ExamplesTest, TheBlocksOfTheGuideToMembersShip) {
  const std::string page = Read("docs/block_members.md"), directory = "docs/examples/members/";
  const std::string programs =
      Read(directory + "values.cc") + Read(directory + "events.cc") + Read(directory + "around.cc");
  for (const std::string& block : Between(page, "```cpp\n", "```"))
    EXPECT_THAT(WithoutIndentation(programs), ::testing::HasSubstr(WithoutIndentation(block)));
  const auto shipped = Between(programs, "\nclass ", " ");
  EXPECT_GE(shipped.size(), 17U);
  for (const std::string& block : shipped) EXPECT_THAT(page, ::testing::HasSubstr("\nclass " + block + " "));
}

TEST(ExamplesTest, TheErrorsOfTheGuideToMembersAreThoseOfItsMistakes) {
  std::string mistakes = Read("docs/examples/members/mistakes.cc");
  for (const auto& file :
       std::filesystem::directory_iterator(std::filesystem::path(TENON_SOURCE_DIR) / "tests/compile/errors"))
    mistakes += Read(file.path());
  const auto errors = Between(Read("docs/block_members.md"), "gives\n  `", "`\n");
  EXPECT_GE(errors.size(), 17U);
  for (const std::string& error : errors) EXPECT_THAT(mistakes, ::testing::HasSubstr(error));
}

// All files that repeat the version of CMakeLists.txt agree with it.
TEST(VersionTest, IsOneEverywhere) {
  const std::string version = TENON_VERSION;
  EXPECT_THAT(Read("CITATION.cff"), ::testing::HasSubstr("\nversion: " + version + "\n"));
  EXPECT_THAT(Read("CHANGELOG.md"), ::testing::HasSubstr("\n## " + version + "\n"));
  EXPECT_THAT(Read("README.md"),
              ::testing::HasSubstr("`libtenon" + version.substr(0, version.rfind('.')) + "`"));
}

}  // namespace tenon::docs::examples_test
