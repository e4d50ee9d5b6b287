#include <tenon/systems/campaign/campaign.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/primitives/noise.h>
#include <tenon/systems/simulation.h>
#include <tenon/tests/testing/block_test.h>

#include <atomic>
#include <cmath>
#include <set>
#include <stdexcept>

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

}  // namespace tenon::campaign_test
