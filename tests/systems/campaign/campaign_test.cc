#include <tenon/systems/campaign/campaign.h>
#include <tenon/systems/campaign/sampling.h>
#include <tenon/systems/campaign/statistics.h>
#include <tenon/systems/primitives/noise.h>
#include <tenon/systems/simulation.h>
#include <tenon/tests/testing/block_test.h>

#include <atomic>
#include <set>

namespace tenon::campaign_test {

using ::testing::HasSubstr;

/// x' = -rate x + noise, from 1.
class Decay final : public LeafSystem<void> {
 public:
  InputPort<double> noise{this, "noise", 0.0};
  Parameter<double> rate{this, {"rate", "1/s"}, 1.0};
  ContinuousState<double> x{this, "x", 1.0};
  OutputPort<double> state{this, x};
  TimeDerivative<double> dx{x, Uses(x, rate, noise),
                            [](double x, double rate, double noise) { return noise - rate * x; }};
};

class CampaignTest : public ::testing::Test {
 protected:
  CampaignTest() { diagram = builder.Build(); }

  auto Run(std::size_t count, int jobs) const {
    return RunCampaign(
        *diagram, count, jobs,
        [this](std::size_t run, Context& context) {
          context.Set(decay.rate, 0.1 * static_cast<double>(run));
        },
        [this](Simulator& simulator) {
          simulator.RunTo(1);
          return simulator.context().Eval(decay.state);
        },
        {.rtol = 1e-10, .atol = 1e-12});
  }

  DiagramBuilder builder;
  Decay& decay = builder.Add<Decay>("decay");
  std::shared_ptr<const Diagram> diagram;
};

TEST_F(CampaignTest, EachRunIsVaried) {
  const auto runs = Run(30, 2);
  ASSERT_EQ(runs.size(), 30U);
  for (std::size_t k = 0; k < runs.size(); ++k) {
    ASSERT_TRUE(runs[k].figures) << runs[k].failure;
    EXPECT_NEAR(*runs[k].figures, std::exp(-0.1 * static_cast<double>(k)), 1e-8);
    EXPECT_EQ(runs[k].seed, 1 + k);
  }
}

TEST_F(CampaignTest, ThreadsGiveTheNumbersOfOne) {
  const auto one = Run(40, 1), four = Run(40, 4);
  for (std::size_t k = 0; k < one.size(); ++k) EXPECT_EQ(*one[k].figures, *four[k].figures);
}

TEST_F(CampaignTest, SeedsFollowFromTheIndex) {
  DiagramBuilder noisy;
  auto& noise = noisy.Add<UniformNoise<double>>("noise", {.rate = Hz(10)});
  const auto with_noise = noisy.Build();
  const auto run = [&](int jobs) {
    return RunCampaign(
        *with_noise, 20, jobs, [](std::size_t, Context&) {},
        [&](Simulator& simulator) {
          simulator.RunTo(0.5);
          return simulator.context().Eval(noise.y);
        },
        {.seed = 7});
  };
  const auto a = run(1), b = run(3);
  std::set<double> values;
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].seed, 7 + k);
    EXPECT_EQ(*a[k].figures, *b[k].figures);
    values.insert(*a[k].figures);
  }
  EXPECT_EQ(values.size(), a.size());
}

TEST_F(CampaignTest, AFailedRunKeepsItsReasonAndTheOthersGoOn) {
  const auto runs = RunCampaign(
      *diagram, 6, 2,
      [this](std::size_t run, Context& context) { context.Set(decay.rate, run == 4 ? -1e4 : 1.0); },
      [this](Simulator& simulator) {
        simulator.RunTo(1);
        if (simulator.context().seed() == 3) throw std::runtime_error("the third is left out");
        return simulator.context().Eval(decay.state);
      });
  for (std::size_t k = 0; k < runs.size(); ++k) EXPECT_EQ(runs[k].figures.has_value(), k != 4 && k != 2) << k;
  EXPECT_EQ(runs[2].failure, "the third is left out");
  EXPECT_THAT(runs[4].failure, HasSubstr("decay"));
}

TEST(ForEachRunTest, ThreadsDoEachRunOnce) {
  std::vector<std::atomic<int>> done(1000);
  ForEachRun(done.size(), 4, [&](std::size_t k) { ++done[k]; });
  for (const auto& times : done) EXPECT_EQ(times, 1);
}

TEST(ForEachRunTest, TheFirstErrorEndsItAndIsThrown) {
  std::atomic<int> count = 0;
  const auto stop = [&](std::size_t k) {
    ++count;
    if (k == 10) throw ParameterError("no more");
  };
  EXPECT_TRUE(Throws<ParameterError>([&] { ForEachRun(100'000'000, 2, stop); }, "no more"));
  EXPECT_LT(count, 100'000'000);
  EXPECT_TRUE(Throws<ParameterError>([&] { ForEachRun(1, 0, stop); }, "jobs = 0 must be positive"));
}

// The first points of the sequence: 1/2; 3/4, 1/4; 3/8, 3/8; ...
TEST(SobolTest, BeginsAsItDoes) {
  const auto points = Sobol(4, 2);
  EXPECT_EQ(points[0][0], 0.5);
  EXPECT_EQ(points[1][0], 0.5);
  EXPECT_EQ(points[0][1] + points[1][1], 1);
  EXPECT_EQ(std::abs(points[0][1] - points[1][1]), 0.5);
}

// In every dimension, 2^m points with the origin put equally many points into each of 64 equal intervals. The
// mean of a smooth function has a smaller error than with random points.
TEST(SobolTest, FillsEvenly) {
  const auto points = Sobol(1023, 5);
  double mean = 0;
  for (std::size_t k = 0; k < 1023; ++k) {
    double product = 1;
    for (const auto& coordinate : points) product *= 2 * coordinate[k];
    mean += product / 1023;
  }
  EXPECT_NEAR(mean, 1, 2e-2);
  for (const auto& coordinate : points) {
    std::multiset<int> intervals{0};
    for (const double x : coordinate) intervals.insert(static_cast<int>(64 * x));
    for (int i = 0; i < 64; ++i) EXPECT_EQ(intervals.count(i), 16U);
  }
}

TEST(SobolTest, OfNothingIsNothingAndDimensionsEnd) {
  EXPECT_TRUE(Sobol(10, 0).empty());
  EXPECT_TRUE(Throws<ParameterError>([] { Sobol(10, 100'000); }, "uniform"));
}

// 81 of 263, 15 of 148: table I of Newcombe, Statistics in Medicine 17 (1998), method 3.
TEST(WilsonIntervalTest, GivesThePublishedIntervals) {
  EXPECT_NEAR(WilsonInterval(81, 263, 0.95).low, 0.2553, 5e-5);
  EXPECT_NEAR(WilsonInterval(81, 263, 0.95).high, 0.3662, 5e-5);
  EXPECT_NEAR(WilsonInterval(15, 148, 0.95).low, 0.0624, 5e-5);
  EXPECT_NEAR(WilsonInterval(15, 148, 0.95).high, 0.1605, 5e-5);
  EXPECT_EQ(WilsonInterval(0, 20, 0.95).low, 0);
  EXPECT_NEAR(WilsonInterval(0, 20, 0.95).high, 0.1611, 5e-5);
  EXPECT_EQ(WilsonInterval(29, 29, 0.95).high, 1);
}

// At the ends, the score test is at its limit: |p - p̂| = z sqrt(p (1 - p) / n).
TEST(WilsonIntervalTest, ItsEndsSolveTheEquationOfTheScoreTest) {
  const double z = 1.6448536269514722;  // 90 %
  for (const std::size_t k : {3U, 17U, 40U}) {
    const Interval interval = WilsonInterval(k, 41, 0.9);
    for (const double p : {interval.low, interval.high})
      EXPECT_NEAR(std::abs(p - static_cast<double>(k) / 41), z * std::sqrt(p * (1 - p) / 41), 1e-12);
  }
}

TEST(WilsonIntervalTest, HoldsWhatItPromises) {
  RandomStream random(3);
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    std::size_t survived = 0;
    for (int k = 0; k < 60; ++k) survived += random.Uniform() < 0.9 ? 1 : 0;
    const Interval interval = WilsonInterval(survived, 60, 0.95);
    inside += interval.low <= 0.9 && 0.9 <= interval.high ? 1 : 0;
  }
  EXPECT_NEAR(inside / 2000.0, 0.95, 0.03);
}

TEST(WilsonIntervalTest, OfNothingIsEverything) {
  EXPECT_EQ(WilsonInterval(0, 0, 0.95).low, 0);
  EXPECT_EQ(WilsonInterval(0, 0, 0.95).width(), 1);
}

TEST(WilsonIntervalTest, RefusesWhatCannotBe) {
  EXPECT_TRUE(Throws<ParameterError>([] { WilsonInterval(3, 2, 0.95); }, "3 successes of 2 trials"));
  EXPECT_TRUE(Throws<ParameterError>([] { WilsonInterval(1, 2, 95); }, "confidence = 95"));
}

std::vector<double> OneTo(int n) {
  std::vector<double> values;
  for (int i = n; i > 0; --i) values.push_back(i);
  return values;
}

// Among 10 values, the median lies between the 2nd and the 9th with a probability of 1 - 2 (1 + 10) / 2^10 =
// 97.9 %, and between the 3rd and the 8th only with 89 %.
TEST(EstimateQuantileTest, OfAMedianHasTheClosedForm) {
  const QuantileEstimate median = EstimateQuantile(OneTo(10), 0.5, 0.95);
  EXPECT_EQ(median.value, 5);
  EXPECT_EQ(median.interval.low, 2);
  EXPECT_EQ(median.interval.high, 9);
  EXPECT_EQ(EstimateQuantile(OneTo(10), 0.5, 0.89).interval.low, 3);
}

// All of n values lie below the quantile with a probability of 0.99^n, which is 2.5 % between 367 and 368.
TEST(EstimateQuantileTest, OfTooFewValuesHasNoUpperEnd) {
  EXPECT_EQ(EstimateQuantile(OneTo(367), 0.99, 0.95).interval.high, INFINITY);
  EXPECT_EQ(EstimateQuantile(OneTo(368), 0.99, 0.95).interval.high, 368);
  EXPECT_EQ(EstimateQuantile({7}, 0.01, 0.95).interval.low, -INFINITY);
  EXPECT_EQ(EstimateQuantile({7}, 0.01, 0.95).value, 7);
}

TEST(EstimateQuantileTest, HoldsWhatItPromises) {
  RandomStream random(4);
  int inside = 0, below = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> values;
    for (int k = 0; k < 200; ++k) values.push_back(random.Uniform());
    const auto [value, interval] = EstimateQuantile(values, 0.9, 0.9);
    inside += interval.low <= 0.9 && 0.9 <= interval.high ? 1 : 0;
    below += value <= 0.9 ? 1 : 0;
  }
  EXPECT_GT(inside / 2000.0, 0.9);
  EXPECT_LT(inside / 2000.0, 0.94) << "it is not wider than it must be";
  EXPECT_NEAR(below / 2000.0, 0.5, 0.08);
}

TEST(EstimateQuantileTest, CountsInfiniteValuesAndRefusesOthers) {
  EXPECT_EQ(EstimateQuantile({1, INFINITY, 2}, 0.9, 0.5).value, INFINITY);
  EXPECT_TRUE(Throws<ParameterError>([] { EstimateQuantile({}, 0.5, 0.9); }, "no values"));
  EXPECT_TRUE(Throws<ParameterError>([] { EstimateQuantile({1, NAN}, 0.5, 0.9); }, "NaN"));
  EXPECT_TRUE(Throws<ParameterError>([] { EstimateQuantile({1}, 1, 0.9); }, "share = 1"));
}

TEST(RankCorrelationTest, SeesOrderNotShape) {
  const std::vector<double> x{1, 2, 3, 4, 5}, up{1, 8, 27, 64, 125}, down{5, 4, 3, 2, -100};
  EXPECT_NEAR(*RankCorrelation(x, up), 1, 1e-15);
  EXPECT_NEAR(*RankCorrelation(x, down), -1, 1e-15);
}

// 1 - 6 sum d² / (n (n² - 1)) without ties; with them Pearson's of the shared ranks.
TEST(RankCorrelationTest, GivesTheClosedForm) {
  EXPECT_NEAR(*RankCorrelation(std::vector<double>{1, 2, 3, 4}, std::vector<double>{2, 1, 4, 3}),
              1 - 6 * 4.0 / 60, 1e-15);
  // Ranks 0.5, 0.5, 2 and 0, 1, 2.
  EXPECT_NEAR(*RankCorrelation(std::vector<double>{7, 7, 9}, std::vector<double>{1, 2, 3}), std::sqrt(3) / 2,
              1e-15);
}

TEST(RankCorrelationTest, OfNothingIsNothing) {
  EXPECT_FALSE(RankCorrelation(std::vector<double>{1, test::kNan, 3}, std::vector<double>{1, 2, 3}));
  EXPECT_FALSE(RankCorrelation(std::vector<double>{1, 2, 3}, std::vector<double>{test::kNan, test::kNan, 3}));
  EXPECT_FALSE(RankCorrelation(std::vector<double>{1, 2}, std::vector<double>{1, 2}));
  EXPECT_FALSE(RankCorrelation(std::vector<double>{1, 1, 1}, std::vector<double>{1, 2, 3}));
}

}  // namespace tenon::campaign_test
