#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/apps/campaign/campaign_schedule.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/testing/expect_throws.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace tenon::apps::campaign_plan_test {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

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

// What is random follows from the seed: the same at every point, and whatever else varies.
TEST(CampaignPlanTest, WhatIsDrawnIsDrawnOncePerSeed) {
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

// The same as if the scenario said it.
TEST(CampaignPlanTest, ADistributionGivesWhatAScenarioWithItDraws) {
  const CampaignPlan plan(File("seeds: {first: 9}\nvary: {payload.mass_kg: {uniform: [2, 3]}}"));
  auto scenario = YamlDocument::Parse("payload: {mass_kg: {uniform: [2, 3]}}", "scenario");
  EXPECT_EQ(std::stod(Varied(plan, 0)["payload.mass_kg"]), scenario.Draw(9)[0].second);
}

TEST(CampaignPlanTest, HypercubesAndSobolFillTheirRange) {
  const CampaignPlan plan(
      File("seeds: {count: 64}\nvary:\n  a: {latin_hypercube: [0, 64]}\n"
           "  b: {latin_hypercube: [0, 64]}\n  c: {sobol: [0, 64]}\n  d: {sobol: [0, 64]}\n"));
  std::map<std::string, std::set<int>> intervals;
  int equal = 0, in_sobol = 0;
  for (std::size_t run = 0; run < 64; ++run) {
    for (const auto& [key, text] : Varied(plan, run))
      intervals[key].insert(static_cast<int>(std::stod(text)));
    auto row = Varied(plan, run);
    equal += row["a"] == row["b"] ? 1 : 0;
    in_sobol += row["c"] == row["d"] ? 1 : 0;
  }
  EXPECT_EQ(intervals["a"].size(), 64U);
  EXPECT_EQ(intervals["b"].size(), 64U);
  EXPECT_GE(intervals["c"].size(), 63U);  // without the origin
  EXPECT_GE(intervals["d"].size(), 63U);
  EXPECT_LT(equal, 5);
  EXPECT_LT(in_sobol, 10);  // its first points are on the diagonal
}

TEST(CampaignPlanTest, RefusesWhatMakesNoSenseWithItsPlace) {
  const auto refused = [](const std::string& rest, const std::string& place, const std::string& what) {
    return Throws<ParameterError>([&] { CampaignPlan plan(File(rest)); }, place, what);
  };
  EXPECT_TRUE(
      refused("vary: {a: {grid: [1], list: [2]}}", "c.yaml:3:11: vary.a: ", "2 ways to vary are given"));
  EXPECT_TRUE(refused("vary: {a: {}}", "c.yaml:3:11: vary.a: ", "0 ways to vary"));
  EXPECT_TRUE(refused("vary: {a: {unifrom: [1, 2]}}", "c.yaml:3:12: ", "nearest valid key is 'uniform'"));
  EXPECT_TRUE(refused("vary: {a: {uniform: [2, 1]}}", "c.yaml:3:", "give the lower bound first"));
  EXPECT_TRUE(
      refused("vary: {a: {normal: [2, -1]}}", "c.yaml:3:", "the second number is the standard deviation"));
  EXPECT_TRUE(refused("vary: {a: {linspace: [0, 1, 1.5]}}", "c.yaml:3:", "a count of 1.5"));
  EXPECT_TRUE(
      refused("vary: {a: {linspace: [0, 1, 1e10]}}", "c.yaml:3:", "give an integer from 2 to 1000000"));
  EXPECT_TRUE(refused("vary: {a: {linspace: [1, 1, 2]}}", "c.yaml:3:11: vary.a: ", "1 stands there twice"));
  EXPECT_TRUE(refused("vary: {a: {grid: [0.05, 1, 0.05]}}", "c.yaml:3:", "0.05 stands there twice"));
  EXPECT_TRUE(refused("vary: {a: {list: [1, 1.0]}}", "c.yaml:3:", "1.0 stands there twice"));
  EXPECT_TRUE(refused("vary: {a: {list: [x], sets: {b: 1}}}", "c.yaml:3:", "factors apply to numbers"));
  EXPECT_TRUE(refused("vary: {a: {grid: [1], sets: {b: 0}}}", "c.yaml:3:", "the factor of b is 0"));
  EXPECT_TRUE(refused("seeds: {count: 0}", "c.yaml:3:", "count = 0 must be from 1"));
  EXPECT_TRUE(refused("seeds: {first: 18446744073709551615}", "c.yaml:3:", "exceed 64 bits"));
  EXPECT_TRUE(refused("duration_s: 0", "c.yaml:", "duration_s = 0 must be positive"));
  EXPECT_TRUE(refused("confidence: 95", "c.yaml:", "confidence = 95 must lie between 0 and 1"));
  EXPECT_TRUE(refused("interval_width: 0", "c.yaml:", "interval_width = 0"));
  EXPECT_TRUE(refused("limit: {key: a, from: 2, to: 1}", "c.yaml:3:", "from = 2 must be below to = 1"));
  EXPECT_TRUE(
      refused("limit: {key: a, to: 1, probability: 1}", "c.yaml:3:", "probability = 1 must lie between"));
  EXPECT_TRUE(refused("limit: {key: a, to: 1, steps: 0}", "c.yaml:3:", "steps = 0"));
  EXPECT_TRUE(refused("limit: {key: a, to: 1}\nestimate: survival", "c.yaml:", "remove estimate"));
  for (const char* other :
       {"set: {a: 2}", "vary: {a: {grid: [1, 2]}}", "vary: {b: {choices: {x: {a: 2}}}}"}) {
    const std::string text = std::string(other) + "\nlimit: {key: ";
    EXPECT_TRUE(refused(text + "a, to: 1}", "c.yaml:4:", "limit: a is also set or varied")) << other;
    EXPECT_TRUE(refused(text + "all, sets: {a: 1}, to: 1}", "c.yaml:4:", "a is also set or varied")) << other;
  }
  EXPECT_TRUE(refused("vary: {all: {grid: [1], sets: {b: 1}}}\nlimit: {key: all, sets: {a: 1}, to: 1}",
                      "c.yaml:4:", "all is also set or varied"));
  EXPECT_TRUE(refused("vary: {seed: {grid: [1, 2]}}", "c.yaml:3:14: vary.seed: ", "use seeds: {first: 1"));
  EXPECT_TRUE(refused("vary: {end_reason: {list: [x]}}", "c.yaml:3:", "'end_reason' is a result of runs"));
  EXPECT_TRUE(
      refused("vary: {a: {grid: [1]}, b: {choices: {x: {a: 2}}}}", "c.yaml:3:", "a is already varied by a"));
  EXPECT_TRUE(
      refused("seeds: {count: 10000000}\nvary: {a: {linspace: [0, 1, 1000]}}", "c.yaml:3:", "too many runs"));
  const std::string thousand = "{linspace: [0, 1, 1000]}";
  EXPECT_TRUE(refused("vary: {a: " + thousand + ", b: " + thousand + ", c: " + thousand + "}",
                      "c.yaml:3:", "more than 10 million points"));
}

/// Works a campaign off, `at_once` runs at a time, each of which survives if `survives` says so; ends them in
/// an order that has nothing to do with that of their starts.
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
  // The first point always survives, the second every other time: 16 runs and 93 are enough (Wilson, 95 %).
  const auto survives = [&](std::size_t run) { return plan.PointOf(run) == 0 || run % 2 == 0; };
  const Worked one = Work(plan, 1, survives), many = Work(plan, 5, survives);
  EXPECT_EQ(one.counted.size(), 16U + 93U);
  EXPECT_EQ(many.counted, one.counted);
  EXPECT_LT(many.started, one.started + 2 * 10);
  // What an earlier process did, in whatever order, counts as well.
  const Worked resumed = Work(plan, 3, survives, {}, {0, 1, 2, 5, 9, 501, 530});
  EXPECT_EQ(resumed.counted, one.counted);
}

TEST(CampaignScheduleTest, FindsALimitByBisection) {
  const CampaignPlan plan(
      File("seeds: {count: 60}\nvary: {a: {grid: [1, 2]}}\n"
           "limit: {key: force_N, from: 0, to: 64, steps: 6, probability: 0.9}"));
  // Up to 21 N the first point survives for sure, the second up to 42 N; beyond never.
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
  // That nobody survives is known after 8 runs, that everybody does after 60: 32 are not enough for 90 %.
  EXPECT_EQ(one.counted.size(), 3U * 60 + 3U * 8 + 3U * 60 + 3U * 8);
}

// The looks share the risk: a survival of 0.95 is taken for less than 0.8 hardly ever, though it is asked
// often.
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

}  // namespace
}  // namespace tenon::apps::campaign_plan_test
