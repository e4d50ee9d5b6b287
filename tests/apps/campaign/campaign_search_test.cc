// The search of a campaign, with an app whose figures are functions of its keys with known minima.

#include <tenon/apps/campaign/campaign_desk.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <nlohmann/json.hpp>

namespace tenon::apps::campaign_search_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr, ::testing::internal::CaptureStdout, ::testing::internal::GetCapturedStdout;

struct BowlScenario : AppScenario {
  double stiffness = 1;
  double damping = 1;
  double edge = -1;  // runs below this damping do not finish
  static FieldList Fields() {
    return With({{"stiffness", &BowlScenario::stiffness},
                 {"damping", &BowlScenario::damping},
                 {"edge", &BowlScenario::edge}});
  }
};

std::atomic<int> runs_made;

/// error = (ln stiffness - ln 300)² + (damping - 2)², moved by the seed; effort = damping.
RunResult RunBowl(const BowlScenario& scenario, const RunOptions&) {
  ++runs_made;
  RunOutcome outcome;
  if (scenario.damping < scenario.edge) {
    outcome.status = {.ended = true, .reason = "it fell"};
    outcome.exit_code = kLimitBroken;
  }
  Summary summary("bowl", scenario.seed, outcome);
  const double off = std::log(scenario.stiffness / 300);
  summary.Set("error",
              off * off + std::pow(scenario.damping - 2, 2) + 1e-3 * static_cast<double>(scenario.seed));
  summary.Set("effort", scenario.damping);
  return {.summary = std::move(summary)};
}

const std::string kBowl =
    "optimise:\n"
    "  vary:\n"
    "    stiffness: {from: 10, to: 10000, start: 1000, logarithmic: true}\n"
    "    damping: {from: 0, to: 5}\n"
    "  minimise: {error: 1}\n"
    "  failed_run_cost: 100\n"
    "  held_back: {first: 11, count: 3}\n";

struct CampaignSearchTest : ::testing::Test {
  CampaignSearchTest() { fs::create_directories(directory_); }
  ~CampaignSearchTest() override { fs::remove_all(directory_); }
  int Search(const std::string& text, const std::string& out, bool resume = false) {
    WriteFile(directory_ / "bowl.yaml", "app: bowl\ndescription: a bowl\ncase: bowl\n");
    const auto file = YamlDocument::Parse(
        "app: bowl\nscenario: " + (directory_ / "bowl.yaml").string() + "\nseeds: {count: 2}\n" + text,
        "search.yaml");
    CaptureStdout();
    runs_made = 0;
    try {
      const int code = SearchCampaign(file, MakeScenarioApp("bowl", "a bowl", RunBowl), Out(out), 2, resume);
      printed_ = GetCapturedStdout();
      return code;
    } catch (...) {
      GetCapturedStdout();
      throw;
    }
  }
  fs::path Out(const std::string& out) const { return directory_ / out; }
  nlohmann::json Json(const std::string& out) const {
    return nlohmann::json::parse(ReadText(Out(out) / "summary.json"));
  }

  fs::path directory_ = test::TemporaryPath("campaign_search");
  std::string printed_;
};

TEST_F(CampaignSearchTest, FindsTheMinimumOfKnownFunctions) {
  EXPECT_EQ(Search(kBowl, "out"), kRan);
  const auto summary = Json("out");
  const auto& best = summary["best"];
  EXPECT_NEAR(best["values"]["stiffness"], 300, 300 * 0.02);
  EXPECT_NEAR(best["values"]["damping"], 2, 0.02);
  EXPECT_NEAR(best["cost"], 1.5e-3, 1e-3);                         // the mean over seeds 1 and 2
  EXPECT_NEAR(summary["held_back"]["best"]["cost"], 12e-3, 1e-3);  // over seeds 11 to 13
  EXPECT_EQ(summary["held_back"]["best"]["runs"], 3);
  EXPECT_NEAR(summary["first"]["cost"], std::pow(std::log(1000. / 300), 2) + 0.25 + 1.5e-3, 1e-9);
  EXPECT_LE(summary["evaluations"], 60);
  EXPECT_THAT(printed_, HasSubstr("cost"));
  EXPECT_THAT(ReadText(Out("out") / "report.html"), HasSubstr("stiffness"));
}

TEST_F(CampaignSearchTest, KeepsTheBoundsOfFigures) {
  EXPECT_EQ(Search(kBowl + "  subject_to: {effort: 1.5}\n", "out"), kRan);
  const auto best = Json("out")["best"];
  EXPECT_NEAR(best["values"]["damping"], 1.5, 0.02);  // the minimum lies beyond the bound
  EXPECT_LE(best["figures"]["effort"], 1.5);
  EXPECT_NEAR(best["values"]["stiffness"], 300, 300 * 0.1);

  EXPECT_EQ(Search(kBowl + "  subject_to: {effort: -1}\n", "never"), kLimitBroken);
  EXPECT_THAT(printed_, HasSubstr("effort is"));
}

TEST_F(CampaignSearchTest, LeavesRegionsInWhichRunsFail) {
  EXPECT_EQ(Search("set: {edge: 2.5}\n" + kBowl, "out"), kRan);
  const auto best = Json("out")["best"];
  EXPECT_EQ(best["finished"], 2);
  EXPECT_NEAR(best["values"]["damping"], 2.5, 0.2);
  EXPECT_EQ(Search("set: {edge: 9}\n" + kBowl + "  evaluations: 4\n", "none"), kLimitBroken);
  EXPECT_THAT(printed_, HasSubstr("it fell"));
}

TEST_F(CampaignSearchTest, ContinuesWithTheSameResult) {
  Search(kBowl, "whole");
  const int all = runs_made;
  fs::create_directories(Out("part"));
  fs::copy(Out("whole") / "evaluations", Out("part") / "evaluations");
  for (int i = 10; i < 100; ++i) fs::remove(Out("part") / "evaluations" / (std::to_string(i) + ".csv"));
  EXPECT_EQ(Search(kBowl, "part", true), kRan);
  EXPECT_EQ(runs_made, all - 2 * 10);
  EXPECT_EQ(ReadText(Out("part") / "search.csv"), ReadText(Out("whole") / "search.csv"));
  EXPECT_EQ(Json("part"), Json("whole"));

  fs::copy_file(Out("whole") / "evaluations" / "1.csv", Out("part") / "evaluations" / "0.csv",
                fs::copy_options::overwrite_existing);
  EXPECT_TRUE(Throws<ParameterError>([&] { Search(kBowl, "part", true); }, "0.csv", "stiffness"));
}

TEST_F(CampaignSearchTest, ErrorsNameTheKey) {
  const auto fails = [&](const std::string& text, const char* place, const char* what) {
    EXPECT_TRUE(Throws<ParameterError>([&] { Search(text, "wrong"); }, place, what)) << text;
  };
  const std::string bowl = "optimise: {failed_run_cost: 1, minimise: {error: 1}, ";
  fails("optimise: {vary: {damping: {from: 0, to: 5}}, minimise: {eror: 1}, failed_run_cost: 1}\n",
        "optimise.minimise", "'error'");
  fails("set: {damping: 1}\n" + kBowl, "optimise.vary", "damping");
  fails(bowl + "vary: {damping: {from: 5, to: 0}}}\n", "optimise.vary.damping", "from");
  fails(bowl + "vary: {damping: {from: 0, to: 5, logarithmic: true}}}\n", "optimise.vary.damping", "from");
  fails(bowl + "vary: {damping: {from: 0, to: 5, start: 6}}}\n", "optimise.vary.damping", "start");
  fails(bowl + "vary: {}}\n", "optimise", "vary");
  fails(bowl + "vary: {a: {from: 0, to: 5, sets: {damping: 1}}, damping: {from: 0, to: 5}}}\n",
        "optimise.vary", "damping");
  for (const char* column : {"cost", "runs", "evaluation", "finished"})
    fails(bowl + "vary: {" + column + ": {from: 0, to: 5, sets: {damping: 1}}}}\n", "optimise.vary", column);
  fails("estimate: survival\n" + kBowl, "search.yaml", "optimise");
}

}  // namespace tenon::apps::campaign_search_test
