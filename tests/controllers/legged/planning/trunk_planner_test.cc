#include <tenon/controllers/legged/planning/trunk_planner.h>
#include <tenon/controllers/legged/planning/wrench_sinusoid.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <numbers>
#include <random>

namespace tenon::trunk_planner_test {

using test::DogBot;

constexpr GaitTiming kTrot{.num_steps = 2, .step = {0, 1, 1, 0}, .stance = 0.15, .swing = 0.115};
constexpr GaitTiming kCrawl{.num_steps = 4, .step = {0, 1, 2, 3}, .stance = 0.15, .swing = 0.115};

/// A robot in its nominal stance under a gait clock that the test drives.
class Walk {
 public:
  explicit Walk(double sway_limit = 80, double bandwidth = 20)
      : rig_(TrunkPlannerParams{.robot = DogBot(), .bandwidth = bandwidth, .sway_limit = sway_limit}) {
    schedule.timing = kTrot;
    state = test::Standing(DogBot());
  }
  const BodyReference& Tick() {
    auto& block = rig_.system();
    rig_.Fix(block.body, body).Fix(block.schedule, schedule).Fix(block.state, state);
    return rig_.Fix(block.wrench, wrench).Tick()[block.reference];
  }
  /// The references of some cycles, tick by tick.
  std::vector<BodyReference> Cycles(int cycles) {
    std::vector<BodyReference> references;
    const int ticks = static_cast<int>(std::lround(1000 * schedule.timing.step_duration()));
    for (int step = 0; step < cycles * schedule.timing.num_steps; ++step) {
      schedule.step = step % schedule.timing.num_steps;
      for (int n = 0; n < ticks; ++n) {
        schedule.step_time = 1e-3 * n;
        references.push_back(Tick());
      }
    }
    return references;
  }
  const NominalStance& stance() { return rig_->stance; }
  TestRig<TrunkPlanner>& rig() { return rig_; }
  /// Ticks until the filter has settled.
  void Wait() {
    for (int n = 0; n < 1500; ++n) Tick();
  }

  BodyReference body;
  ContactSchedule schedule;
  LeggedState state;
  WrenchEstimate wrench;

 private:
  TestRig<TrunkPlanner> rig_;
};

/// The rotation vector from the level attitude.
Vec<3> Angle(const BodyReference& reference) {
  const Eigen::AngleAxisd turn(RotationFromQuaternion(reference.q_WB));
  return turn.angle() * turn.axis();
}

TEST(TrunkPlannerTest, IsLevelWithoutAPush) {
  for (const BodyReference& reference : Walk().Cycles(2)) {
    EXPECT_EQ(Angle(reference), Vec<3>::Zero());
    EXPECT_EQ(reference.w_W, Vec<3>::Zero());
    EXPECT_EQ(reference.alpha_W, Vec<3>::Zero());
  }
}

// The ground exerts no torque about the line of the two feet: push and sway are balanced.
TEST(TrunkPlannerTest, InSwingTheTrunkTurnsAboutTheLineOfTheFeet) {
  Walk walk;
  walk.wrench.force_W = {10, 40, -80};
  walk.wrench.torque_W = {3, -2, 5};
  walk.schedule.step = 1;
  walk.schedule.step_time = 0.2;  // front right and rear left are in the air
  walk.Wait();
  const Vec<3> alpha = walk.Tick().alpha_W;
  const Vec<3> front = DogBot().FootPosition(kFrontLeft, walk.state.q),
               rear = DogBot().FootPosition(kRearRight, walk.state.q);
  const Vec<3> line = (front - rear).normalized();
  EXPECT_NEAR(std::abs(alpha.normalized().dot(line)), 1, 1e-12);
  // Forces at the two feet that hold the CoM against the horizontal push, whatever their vertical parts.
  for (const double share : {-0.5, 0.3, 1.0}) {
    const Vec<3> push(10, 40, 0), at_front = -share * push + Vec<3>(0, 0, 70),
                                  at_rear = -(1 - share) * push + Vec<3>(0, 0, 90);
    const Vec<3> x = walk.stance().com_B;
    Vec<3> torque = walk.wrench.torque_W + (front - x).cross(at_front) + (rear - x).cross(at_rear);
    torque -= ((front + rear) / 2 - x).cross(Vec<3>(0, 0, 160));  // the CoM is not quite over their line
    EXPECT_NEAR(line.dot(torque), line.dot(walk.stance().inertia_B * alpha), 0.1);
  }
}

TEST(TrunkPlannerTest, IsLevelAtBothEndsOfASwingAndTurnsBackInStance) {
  Walk walk;
  walk.wrench.force_W = {0, 30, 0};
  walk.Wait();
  const std::vector<BodyReference> references = walk.Cycles(3);
  const std::size_t step = 265, stance = 150, first = 2 * step;  // of the second cycle
  const BodyReference &lift_off = references[first + stance], &last = references[first + step - 1];
  EXPECT_LT(Angle(lift_off).norm(), 1e-12);
  EXPECT_LT(Angle(last).norm(), 2e-3);
  EXPECT_LT((lift_off.w_W + last.w_W).norm(), 0.02 * last.w_W.norm());
  EXPECT_LT(lift_off.alpha_W.dot(lift_off.w_W), 0);
  double most = 0;
  for (std::size_t i = first + stance; i < first + step; ++i)
    most = std::max(most, Angle(references[i]).norm());
  EXPECT_NEAR(most, lift_off.alpha_W.norm() * 0.115 * 0.115 / 8, 1e-4);
  for (std::size_t i = first + stance; i < references.size(); ++i)
    ASSERT_LT((references[i].w_W - references[i - 2 * step].w_W).norm(), 1e-9) << i;
}

TEST(TrunkPlannerTest, RatesAreTheDerivatives) {
  Walk walk;
  walk.wrench.force_W = {5, 10, 0};
  walk.Wait();
  const std::vector<BodyReference> r = walk.Cycles(2);
  for (std::size_t i = 1; i + 1 < r.size(); ++i) {
    const Vec<3> rate = (Angle(r[i + 1]) - Angle(r[i - 1])) / 2e-3,
                 alpha = (r[i + 1].w_W - r[i - 1].w_W) / 2e-3;
    ASSERT_THAT(r[i].w_W, IsNear(rate, 0.01)) << i;
    const std::size_t t = i % 265;  // the acceleration jumps at lift-off and touchdown
    if (t <= 1 || t >= 264 || std::abs(static_cast<int>(t) - 150) <= 1) continue;
    ASSERT_THAT(r[i].alpha_W, IsNear(alpha, 0.1)) << i;
  }
}

TEST(TrunkPlannerTest, StaysLevelOnThreeFeetAndStanding) {
  Walk walk;
  walk.wrench.force_W = {0, 60, 0};
  walk.schedule.timing = kCrawl;
  for (const BodyReference& reference : walk.Cycles(1)) ASSERT_EQ(reference.w_W, Vec<3>::Zero());
  walk.schedule.timing = GaitTiming();
  EXPECT_EQ(walk.Tick().w_W, Vec<3>::Zero());
}

TEST(TrunkPlannerTest, IsLimited) {
  Walk walk(60), level(0);
  walk.wrench.force_W = level.wrench.force_W = {0, 1e4, 0};
  for (const BodyReference& reference : walk.Cycles(2)) {
    ASSERT_LT(Angle(reference).norm(), 0.1);
    ASSERT_LT(reference.alpha_W.norm(), 60 + 1e-9);
  }
  for (const BodyReference& reference : level.Cycles(1)) ASSERT_EQ(reference.w_W, Vec<3>::Zero());
}

TEST(TrunkPlannerTest, IsOnTopOfTheReferenceOfTheBody) {
  Walk walk;
  walk.wrench.force_W = {0, 30, 0};
  walk.body.com_W = {1, 2, 3};
  walk.body.q_WB = QuaternionFromRotationVector({0, 0, 1});
  walk.body.w_W = {0, 0, 0.5};
  walk.schedule.step_time = 0.2;
  const BodyReference there = walk.Tick();
  EXPECT_EQ(there.com_W, walk.body.com_W);
  Walk plain;
  plain.wrench = walk.wrench;
  plain.schedule = walk.schedule;
  const BodyReference level = plain.Tick();
  EXPECT_THAT(there.w_W, IsNear(Vec<3>(level.w_W + walk.body.w_W), 1e-12));
  EXPECT_THAT(there.q_WB, IsNear(QuaternionProduct(level.q_WB, walk.body.q_WB), 1e-12));
}

TEST(TrunkPlannerTest, FiltersThePush) {
  Walk walk;
  walk.schedule.step_time = 0.2;
  walk.wrench.force_W = {0, 30, 0};
  const double first = walk.Tick().alpha_W.norm();
  for (int n = 0; n < 49; ++n) walk.Tick();  // 50 ms, the filter's time constant
  const double later = walk.Tick().alpha_W.norm();
  walk.Wait();
  const double last = walk.Tick().alpha_W.norm();
  EXPECT_NEAR(first / last, 1 - std::exp(-0.02), 1e-9);
  EXPECT_NEAR(later / last, 1 - std::exp(-1.02), 1e-9);
}

TEST(TrunkPlannerTest, BandwidthAndLimitAreSetInARun) {
  const auto cycle = [](Walk& walk) {
    walk.wrench.force_W = {5, 60, 0};
    std::vector<double> numbers;
    for (const BodyReference& reference : walk.Cycles(2)) {
      numbers.insert(numbers.end(), reference.w_W.begin(), reference.w_W.end());
      numbers.insert(numbers.end(), reference.q_WB.begin(), reference.q_WB.end());
    }
    return numbers;
  };
  Walk plain, set, built(30, 5);
  set.rig().Set(set.rig()->sway_limit, 30).Set(set.rig()->bandwidth, 5);
  const std::vector<double> expected = cycle(built);
  EXPECT_EQ(cycle(set), expected);
  EXPECT_NE(cycle(plain), expected);
}

constexpr double kStep = 0.01, kTwoPi = 2 * std::numbers::pi;

/// A mean plus a sinusoid along one direction, with noise.
struct Signal {
  double hertz, mean, amplitude, noise;
  Vec<6> At(double t) const {
    Vec<6> y = Vec<6>::Zero();
    y[1] = mean + amplitude * std::sin(kTwoPi * hertz * t);
    y[3] = -0.5 * y[1];
    return y;
  }
};

/// The largest error of a forecast over 0.6 s in the second after `end`, over the amplitude. The error
/// of a wrench which is held comes to 2.
double ForecastError(const Signal& signal, double end) {
  WrenchSinusoid sinusoid;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, signal.noise);
  double worst = 0;
  for (int n = 0; n * kStep < end + 1; ++n) {
    const double t = n * kStep;
    Vec<6> measured = signal.At(t);
    for (double& y : measured) y += noise(random);
    sinusoid.Update(measured, kStep);
    if (t < end) continue;
    for (const double ahead : {0.0, 0.2, 0.4, 0.6})
      worst = std::max(worst, (sinusoid.After(ahead) - signal.At(t + ahead)).norm());
  }
  return worst / signal.amplitude;
}

TEST(WrenchSinusoidTest, ForecastsMeanAndSinusoidAfterAFewPeriods) {
  EXPECT_LT(ForecastError({.hertz = 0.25, .mean = 0, .amplitude = 0.1, .noise = 0}, 16), 0.15);
  EXPECT_LT(ForecastError({.hertz = 0.5, .mean = 0.05, .amplitude = 0.1, .noise = 0}, 10), 0.15);
  EXPECT_LT(ForecastError({.hertz = 1, .mean = -0.1, .amplitude = 0.1, .noise = 0}, 8), 0.15);
  EXPECT_LT(ForecastError({.hertz = 2, .mean = 0.1, .amplitude = 0.1, .noise = 0}, 8), 0.25);
  EXPECT_LT(ForecastError({.hertz = 1, .mean = 0.1, .amplitude = 0.1, .noise = 0.003}, 8), 0.3);
}

TEST(WrenchSinusoidTest, AConstantWrenchIsItsMean) {
  const Vec<6> wrench = Vec<6>::LinSpaced(-0.1, 0.2);
  WrenchSinusoid sinusoid;
  for (int n = 0; n < 2000; ++n) sinusoid.Update(wrench, kStep);
  EXPECT_LT((sinusoid.mean - wrench).norm(), 1e-3);
  for (const double ahead : {0.0, 0.3, 0.6}) EXPECT_LT((sinusoid.After(ahead) - wrench).norm(), 1e-3);
}

TEST(WrenchSinusoidTest, NoiseAloneKeepsTheFrequencyWithinItsLimits) {
  WrenchSinusoid sinusoid;
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 1);
  for (int n = 0; n < 5000; ++n) {
    Vec<6> wrench;
    for (double& y : wrench) y = noise(random);
    sinusoid.Update(wrench, kStep);
    ASSERT_GE(sinusoid.frequency, 1);
    ASSERT_LE(sinusoid.frequency, 25);
    ASSERT_LT(sinusoid.After(0.5).norm(), 20);
  }
}

}  // namespace tenon::trunk_planner_test
