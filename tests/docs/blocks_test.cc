// The generated pages of docs/ are up to date.

#include <tenon/docs/catalogue/documents.h>
#include <tenon/docs/catalogue/headers.h>
#include <tenon/docs/catalogue/scenario_page.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

namespace tenon::docs::blocks_test {
namespace {

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
  EXPECT_EQ(declarations.at("Gain").summary, "A multiplication by a scalar.");
  EXPECT_EQ(declarations.at("QuadrupedPlant").summary,
            "A quadruped on terrain: rigid bodies in Simbody (quadruped_body.h), compliant "
            "contacts with friction (foot_contact.h).");
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
                                      "gain"};
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
}

TEST(ScenarioPageTest, KeysAndMeaningsAreUpToDate) {
  ExpectUpToDate("docs/keys/meanings.yaml", WriteMeanings(kSource));
  ExpectUpToDate("docs/scenarios.md", WriteScenarioKeys());
}

TEST(ScenarioPageTest, DocstringsAreFoundWhereverTheyStand) {
  const std::string meanings = WriteMeanings(kSource);
  for (const char* line :
       {"  PathScenario:\n",
        "    ramp_s: \"time in which the circle's speed is reached\"\n",  // behind the member
        "    attitude_rad: \"Roll, pitch, yaw all along the path",        // above the member
        "    desired_tension_N: \"f_d\"\n",                               // without the unit of the key
        "    about: \"Limits of the trunk's pose beyond which a robot counts as fallen.\"\n"})
    EXPECT_NE(meanings.find(line), meanings.npos) << line;
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

}  // namespace
}  // namespace tenon::docs::blocks_test
