// The generated pages of docs/ are up to date.

#include <tenon/docs/catalogue/documents.h>
#include <tenon/docs/catalogue/headers.h>
#include <tenon/docs/catalogue/scenario_page.h>
#include <tenon/tests/testing/temporary_path.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace tenon::docs::blocks_test {

namespace fs = std::filesystem;

const fs::path kSource = TENON_SOURCE_DIR;
constexpr const char* kRenew = "; renew it by tools/docs --blocks";

std::vector<std::string> ReadLines(std::istream&& in) {
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(BlocksTest, EveryBlockOfThePublicHeadersIsInTheCatalogue) {
  std::set<std::string> known;
  for (const Shelf& shelf : MakeCatalogue()) {
    for (const Entry& entry : shelf.entries) known.insert(entry.name);
  }
  int blocks = 0;
  for (const auto& [name, declaration] : ReadHeaders(kSource)) {
    if (!declaration.is_block) continue;
    ++blocks;
    EXPECT_TRUE(known.contains(name))
        << declaration.header << " declares " << name << ": put it into docs/catalogue/catalogue.cc";
  }
  EXPECT_EQ(blocks, known.size());
}

TEST(BlocksTest, HeadersHaveSummaries) {
  const auto declarations = ReadHeaders(kSource);
  EXPECT_EQ(declarations.at("Gain").header, "systems/primitives/gain.h");
  const std::string plant = declarations.at("QuadrupedPlant").summary;  // one sentence on two lines
  EXPECT_THAT(plant,
              testing::AllOf(testing::HasSubstr("quadruped_body.h"), testing::HasSubstr("foot_contact.h"),
                             testing::EndsWith("."), testing::Not(testing::HasSubstr("\n"))));
  EXPECT_FALSE(declarations.at("LeggedState").is_block);
  for (const auto& [name, declaration] : declarations) {
    EXPECT_TRUE(!declaration.is_block || !declaration.summary.empty()) << name;
  }
}

TEST(BlocksTest, ParametersHaveDescriptionsAndUnits) {
  // Ratios, counts and flags, and a gain whose unit depends on its use.
  const std::set<std::string> no_unit{"early_touchdown_phase",
                                      "friction",
                                      "outlier",
                                      "max_failures_in_a_row",
                                      "max_fallbacks_in_a_row",
                                      "forbid_slack",
                                      "max_tension_ratio",
                                      "on_trunk",
                                      "active",
                                      "gait",
                                      "stands",
                                      "grip",
                                      "goal",
                                      "gain",
                                      "share"};
  int count = 0;
  for (const Shelf& shelf : MakeCatalogue()) {
    for (const Entry& entry : shelf.entries) {
      for (const Source* source : entry.block->sources()) {
        if (source->kind() != SourceKind::kParameter) continue;
        ++count;
        const std::string name = entry.title + "." + source->name();
        EXPECT_FALSE(static_cast<const internal::ParameterSource*>(source)->description().empty()) << name;
        // The units of a primitive are those of its signals.
        const bool generic =
            entry.title.find('<') != std::string::npos || entry.title.ends_with("StateSpace");
        if (generic || no_unit.contains(source->name())) continue;
        for (const Element& element : source->elements())
          EXPECT_TRUE(!element.unit.empty() || element.name.size() > 1) << name;
      }
    }
  }
  EXPECT_GT(count, 60);
}

/// Expects that a file of the source tree has the text that would be generated now.
void ExpectUpToDate(const char* file, const std::string& text) {
  const auto found = ReadLines(std::ifstream(kSource / file));
  const auto wanted = ReadLines(std::istringstream(text));
  const auto [ours, theirs] = std::mismatch(found.begin(), found.end(), wanted.begin(), wanted.end());
  EXPECT_TRUE(ours == found.end() && theirs == wanted.end())
      << file << ", line " << ours - found.begin() + 1 << ", is\n  "
      << (ours == found.end() ? "missing" : *ours) << "\nand should be\n  "
      << (theirs == wanted.end() ? "missing" : *theirs) << kRenew;
}

TEST(BlocksTest, ThePageIsUpToDate) {
  ExpectUpToDate("docs/blocks.md", WriteBlocks(kSource));
  EXPECT_THAT(WriteBlocks(kSource), testing::Not(testing::ContainsRegex("else *\\|"))) << "no default";
}

TEST(ScenarioPageTest, KeysAndMeaningsAreUpToDate) {
  ExpectUpToDate("docs/keys/meanings.yaml", WriteMeanings(kSource));
  ExpectUpToDate("docs/scenarios.md", WriteScenarioKeys());
}

TEST(ScenarioPageTest, DocstringsAreFoundWhereverTheyStand) {
  const fs::path source = test::TemporaryPath("docstrings");
  for (const char* directory : {"systems", "plants", "controllers", "diagrams", "apps"})
    fs::create_directories(source / directory);
  std::ofstream(source / "apps" / "path_scenario.h") << R"(
/// About the struct,
/// in two lines.
struct PathScenario {
  double ramp_s = 5;      ///< behind the member
  /// Above the member.
  double period_s = 10;
  double radius_m = 0.5;  ///< without its unit [m]

  static FieldList Fields() {
    return {{"ramp_s", &PathScenario::ramp_s},
            {"period_s", &PathScenario::period_s},
            {"radius_m", &PathScenario::radius_m}};
  }
};
)";
  const std::string meanings = WriteMeanings(source);
  for (const char* line :
       {"  PathScenario:\n", "    ramp_s: \"behind the member\"\n", "    period_s: \"Above the member.\"\n",
        "    radius_m: \"without its unit\"\n", "    about: \"About the struct, in two lines.\"\n"})
    EXPECT_NE(meanings.find(line), meanings.npos) << line << meanings;
  fs::remove_all(source);
}

TEST(ScenarioPageTest, EveryKeyHasADocstring) {
  std::istringstream page(WriteScenarioKeys());
  int keys = 0;
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| `")) continue;
    ++keys;
    EXPECT_FALSE(line.ends_with("|  |")) << line << " needs a docstring at its member" << kRenew;
  }
  EXPECT_GT(keys, 300);
}

TEST(BlocksTest, ThePicturesAreUpToDate) {
  for (const Picture& picture : MakePictures()) {
    EXPECT_TRUE(IsUpToDate(picture, kSource / "docs/diagrams"))
        << "docs/diagrams/" << picture.name << ".svg shows the diagram as it was" << kRenew;
  }
}

}  // namespace tenon::docs::blocks_test
