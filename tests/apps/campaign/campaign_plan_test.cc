#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/tests/testing/block_test.h>

#include <set>

namespace tenon::apps::campaign_plan_test {

using ::testing::ElementsAre, ::testing::Pair;

const std::string kHead = "app: tenon-quadruped\nscenario: A4\n";

YamlDocument File(const std::string& rest) {
  return YamlDocument::Parse(kHead + rest, "c.yaml");
}

std::map<std::string, std::string> Varied(const CampaignPlan& plan, std::size_t run) {
  const auto varied = plan.Setup(run).varied;
  return {varied.begin(), varied.end()};
}

TEST(CampaignPlanTest, GridsAndListsMultiplyWithEachOtherAndTheSeeds) {
  const CampaignPlan plan(
      File("seeds: {first: 7, count: 3}\n"
           "set: {log_rate_hz: 10}\n"
           "vary:\n"
           "  walk.friction: {grid: [0.4, 0.6]}\n"
           "  observer: {list: [legs, none]}\n"
           "  forces.0.force_N: {list: [[1, 0, 0]]}\n"));
  EXPECT_EQ(plan.num_points(), 4U);
  EXPECT_EQ(plan.size(), 12U);
  const RunSetup setup = plan.Setup(7);  // the third point's second seed
  EXPECT_EQ(setup.seed, 8U);
  EXPECT_EQ(setup.scenario, "A4");
  EXPECT_THAT(setup.settings, ElementsAre(Pair("log_rate_hz", "10"), Pair("walk.friction", "0.6"),
                                          Pair("observer", "legs"), Pair("forces.0.force_N", "[1, 0, 0]")));
  EXPECT_THAT(setup.varied, ElementsAre(Pair("walk.friction", "0.6"), Pair("observer", "legs"),
                                        Pair("forces.0.force_N", "[1, 0, 0]")));
}

TEST(CampaignPlanTest, AChoiceSetsSeveralKeysAndEvenTheScenario) {
  const CampaignPlan plan(
      File("vary:\n"
           "  who: {choices: {ours: {}, thesis: {profile: thesis, observer: legs}}}\n"
           "  scenario: {list: [A4, B3-plus]}\n"));
  EXPECT_THAT(plan.Setup(0).settings, ElementsAre());
  EXPECT_THAT(plan.Setup(3).settings, ElementsAre(Pair("observer", "legs"), Pair("profile", "thesis")));
  EXPECT_EQ(plan.Setup(3).scenario, "B3-plus");
  EXPECT_THAT(plan.Setup(3).varied, ElementsAre(Pair("who", "thesis"), Pair("scenario", "B3-plus")));
  EXPECT_THAT(plan.Scenarios(), ElementsAre("A4", "B3-plus"));
  const CampaignPlan some(File("vary: {who: {choices: {a: {scenario: B2}, b: {walk.friction: 0.5}}}}"));
  EXPECT_THAT(some.Scenarios(), ElementsAre("A4", "B2"));
  EXPECT_EQ(some.Setup(1).scenario, "A4");
}

TEST(CampaignPlanTest, OneValueMaySetSeveralKeysByFactors) {
  const CampaignPlan plan(
      File("vary: {force_N: {linspace: [0, 40, 5], sets: {a.upper_N: 1, a.lower_N: 0.25}}}"));
  EXPECT_EQ(plan.num_points(), 5U);
  EXPECT_THAT(plan.Setup(3).varied, ElementsAre(Pair("force_N", "30")));
  EXPECT_THAT(plan.Setup(3).settings, ElementsAre(Pair("a.lower_N", "7.5"), Pair("a.upper_N", "30")));
}

// A random value depends on its key and the seed, not on the point or on the other keys.
TEST(CampaignPlanTest, RandomValuesAreDrawnOncePerSeed) {
  const std::string drawn =
      "  walk.mass_error_ratio: {uniform: [-0.3, 0.3]}\n  m: {normal: [5, 1]}\n"
      "  l: {lognormal: [0, 1]}\n";
  const CampaignPlan plan(File("seeds: {count: 50}\nvary:\n  walk.friction: {grid: [0.4, 0.6]}\n" + drawn));
  const CampaignPlan alone(File("seeds: {count: 50}\nvary:\n" + drawn));
  std::set<std::string> values;
  for (std::size_t k = 0; k < 50; ++k) {
    auto first = Varied(plan, k), second = Varied(plan, 50 + k);
    EXPECT_EQ(first["walk.friction"], "0.4");
    EXPECT_EQ(second["walk.friction"], "0.6");
    for (const std::string key : {"walk.mass_error_ratio", "m", "l"}) {
      EXPECT_EQ(first[key], second[key]);
      EXPECT_EQ(first[key], Varied(alone, k)[key]);
    }
    EXPECT_LE(std::abs(std::stod(first["walk.mass_error_ratio"])), 0.3);
    EXPECT_GT(std::stod(first["l"]), 0);
    values.insert(first["m"]);
  }
  EXPECT_EQ(values.size(), 50U);
}

// The value equals that of a scenario with the distribution.
TEST(CampaignPlanTest, ADistributionGivesWhatAScenarioWithItDraws) {
  const CampaignPlan plan(File("seeds: {first: 9}\nvary: {payload.mass_kg: {uniform: [2, 3]}}"));
  auto scenario = YamlDocument::Parse("payload: {mass_kg: {uniform: [2, 3]}}", "scenario");
  EXPECT_EQ(std::stod(Varied(plan, 0)["payload.mass_kg"]), scenario.Draw(9)[0].second);
}

TEST(CampaignPlanTest, SobolFillsItsRange) {
  const CampaignPlan plan(File("seeds: {count: 64}\nvary: {c: {sobol: [0, 64]}, d: {sobol: [0, 64]}}\n"));
  std::map<std::string, std::set<int>> intervals;
  int in_sobol = 0;
  for (std::size_t run = 0; run < 64; ++run) {
    for (const auto& [key, text] : Varied(plan, run))
      intervals[key].insert(static_cast<int>(std::stod(text)));
    auto row = Varied(plan, run);
    in_sobol += row["c"] == row["d"] ? 1 : 0;
  }
  EXPECT_GE(intervals["c"].size(), 63U);  // the sequence leaves out the origin
  EXPECT_GE(intervals["d"].size(), 63U);
  EXPECT_LT(in_sobol, 10);  // its first points are on the diagonal
}

TEST(CampaignPlanTest, RefusesBadCampaignsWithTheirPlace) {
  const std::string thousand = "{linspace: [0, 1, 1000]}";
  for (const auto& [text, place] : std::vector<std::pair<std::string, std::string>>{
           {"vary: {a: {grid: [1], list: [2]}}", "c.yaml:3:11: vary.a: "},
           {"vary: {a: {}}", "c.yaml:3:11: vary.a: "},
           {"vary: {a: {unifrom: [1, 2]}}", "'uniform'"},
           {"vary: {a: {uniform: [2, 1]}}", "c.yaml:3:"},
           {"vary: {a: {normal: [2, -1]}}", "c.yaml:3:"},
           {"vary: {a: {linspace: [0, 1, 1.5]}}", "c.yaml:3:"},
           {"vary: {a: {linspace: [0, 1, 1e10]}}", "c.yaml:3:"},
           {"vary: {a: {linspace: [1, 1, 2]}}", "c.yaml:3:11: vary.a: "},
           {"vary: {a: {grid: [0.05, 1, 0.05]}}", "c.yaml:3:"},
           {"vary: {a: {list: [1, 1.0]}}", "c.yaml:3:"},
           {"vary: {a: {list: [x], sets: {b: 1}}}", "c.yaml:3:"},
           {"vary: {a: {grid: [1], sets: {b: 0}}}", "c.yaml:3:"},
           {"vary: {a: {grid: [1]}, b: {choices: {x: {a: 2}}}}", "c.yaml:3:"},
           {"vary: {seed: {grid: [1, 2]}}", "c.yaml:3:14: vary.seed: "},
           {"vary: {end_reason: {list: [x]}}", "'end_reason'"},
           {"vary: {a: " + thousand + ", b: " + thousand + ", c: " + thousand + "}", "c.yaml:3:"},
           {"seeds: {count: 0}", "count = 0"},
           {"seeds: {first: 18446744073709551615}", "c.yaml:3:"},
           {"seeds: {count: 10000000}\nvary: {a: {linspace: [0, 1, 1000]}}", "c.yaml:3:"},
           {"duration_s: 0", "duration_s = 0"},
           {"confidence: 95", "confidence = 95"},
           {"interval_width: 0", "interval_width = 0"},
           {"limit: {key: a, from: 2, to: 1}", "c.yaml:3:"},
           {"limit: {key: a, to: 1, probability: 1}", "probability = 1"},
           {"limit: {key: a, to: 1, steps: 0}", "steps = 0"},
           {"limit: {key: a, to: 1}\nestimate: survival", "estimate"},
           {"set: {a: 2}\nlimit: {key: a, to: 1}", "c.yaml:4:"},
           {"vary: {a: {grid: [1, 2]}}\nlimit: {key: a, to: 1}", "c.yaml:4:"},
           {"vary: {b: {choices: {x: {a: 2}}}}\nlimit: {key: a, to: 1}", "c.yaml:4:"},
           {"set: {a: 2}\nlimit: {key: all, sets: {a: 1}, to: 1}", "c.yaml:4:"},
           {"vary: {all: {grid: [1], sets: {b: 1}}}\nlimit: {key: all, sets: {a: 1}, to: 1}", "c.yaml:4:"}})
    EXPECT_TRUE(Throws<ParameterError>([&text = text] { CampaignPlan plan(File(text)); }, "c.yaml", place))
        << text;
}

/// Runs a campaign with `at_once` runs at a time, which survive if `survives(run)`. The runs end in another
/// order than they start.
struct Worked {
  std::set<std::size_t> counted;
  std::size_t started = 0;
  std::vector<CampaignSchedule::Limit> limits;
};
Worked Work(const CampaignPlan& plan, std::size_t at_once, const std::function<bool(std::size_t)>& survives,
            Shard shard = {}, const std::set<std::size_t>& before = {}) {
  CampaignSchedule schedule(plan, shard, 2 * at_once);
  for (const std::size_t run : before) schedule.Done(run, survives(run));
  std::vector<std::size_t> under_way;
  std::set<std::size_t> done = before;
  Worked worked;
  for (std::size_t turn = 0;; ++turn) {
    while (under_way.size() < at_once) {
      const auto run = schedule.Next();
      if (!run) break;
      EXPECT_FALSE(done.contains(*run)) << *run;
      under_way.push_back(*run);
      ++worked.started;
    }
    if (under_way.empty()) break;
    const auto next = under_way.begin() + static_cast<std::ptrdiff_t>(turn * 7 % under_way.size());
    schedule.Done(*next, survives(*next));
    done.insert(*next);
    under_way.erase(next);
  }
  EXPECT_TRUE(schedule.finished());
  for (const std::size_t run : done)
    if (schedule.Counts(run)) worked.counted.insert(run);
  if (plan.file().limit)
    for (std::size_t point = 0; point < plan.num_points(); ++point)
      worked.limits.push_back(schedule.LimitAt(point));
  return worked;
}

TEST(CampaignScheduleTest, DoesEveryRunOnceAndShardsMakeTheWhole) {
  const CampaignPlan plan(File("seeds: {count: 5}\nvary: {a: {grid: [1, 2, 3]}}"));
  const auto all = [](std::size_t) { return true; };
  EXPECT_EQ(Work(plan, 1, all).counted.size(), 15U);
  EXPECT_EQ(Work(plan, 4, all).started, 15U);
  EXPECT_EQ(Work(plan, 4, all, {}, {0, 7, 14}).started, 12U);
  std::set<std::size_t> together;
  for (std::size_t i = 1; i <= 4; ++i) {
    const auto part = Work(plan, 2, all, {i, 4});
    EXPECT_EQ(part.counted.size(), *CampaignSchedule(plan, {i, 4}, 1).total());
    together.insert(part.counted.begin(), part.counted.end());
  }
  EXPECT_EQ(together.size(), 15U);
}

TEST(CampaignScheduleTest, EstimatesUntilTheIntervalIsNarrow) {
  const CampaignPlan plan(
      File("seeds: {count: 500}\nvary: {a: {grid: [1, 2]}}\nestimate: survival\ninterval_width: 0.2"));
  // The first point always survives and the second in half of its runs. The Wilson intervals (95 %) are
  // narrow enough after 16 and 93 runs.
  const auto survives = [&](std::size_t run) { return plan.PointOf(run) == 0 || run % 2 == 0; };
  const Worked one = Work(plan, 1, survives), many = Work(plan, 5, survives);
  EXPECT_EQ(one.counted.size(), 16U + 93U);
  EXPECT_EQ(many.counted, one.counted);
  EXPECT_LT(many.started, one.started + 2 * 10);
  // Runs of an earlier process count too, in any order.
  const Worked resumed = Work(plan, 3, survives, {}, {0, 1, 2, 5, 9, 501, 530});
  EXPECT_EQ(resumed.counted, one.counted);
}

TEST(CampaignScheduleTest, FindsALimitByBisection) {
  const CampaignPlan plan(
      File("seeds: {count: 60}\nvary: {a: {grid: [1, 2]}}\n"
           "limit: {key: force_N, from: 0, to: 64, steps: 6, probability: 0.9}"));
  // The first point survives up to 21 N, the second up to 42 N.
  const auto survives = [&](std::size_t run) {
    return plan.LevelValue(plan.LevelOf(run)) <= 21.0 * static_cast<double>(1 + plan.PointOf(run));
  };
  const Worked one = Work(plan, 1, survives), many = Work(plan, 4, survives);
  EXPECT_EQ(one.limits[0].survives, 21);
  EXPECT_EQ(one.limits[0].fails, 22);
  EXPECT_EQ(one.limits[1].survives, 42);
  EXPECT_EQ(one.limits[1].fails, 43);
  EXPECT_EQ(many.counted, one.counted);
  EXPECT_EQ(many.limits[0].survives, 21);
  // 8 runs show that none survives, 60 that all do; 32 are too few for 90 %.
  EXPECT_EQ(one.counted.size(), 3U * 60 + 3U * 8 + 3U * 60 + 3U * 8);
}

// All looks at the data together keep the confidence: a survival of 0.95 is rarely taken for less than 0.8.
TEST(CampaignScheduleTest, ALimitIsFoundWithItsConfidence) {
  const CampaignPlan plan(
      File("seeds: {count: 200}\nlimit: {key: a, from: 0, to: 1, steps: 1, probability: 0.8}"));
  int wrong = 0;
  for (std::uint64_t trial = 0; trial < 400; ++trial) {
    const auto survives = [&](std::size_t run) {
      return RandomStream(trial, std::to_string(run)).Uniform() < 0.95;
    };
    wrong += Work(plan, 2, survives).limits[0].survives == 0.5 ? 0 : 1;
  }
  EXPECT_LT(wrong, 400 * 0.05);
}

}  // namespace tenon::apps::campaign_plan_test
