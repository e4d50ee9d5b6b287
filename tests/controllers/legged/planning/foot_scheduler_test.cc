#include <tenon/controllers/legged/planning/foot_scheduler.h>
#include <tenon/controllers/legged/planning/step_timing_adapter.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <random>
#include <set>

namespace tenon::foot_scheduler_test {

using enum ContactState;

FootSchedulerParams Standard() {
  return YamlDocument::Load(TENON_GAITS_DIR "/standard.yaml")
      .Read<GaitFile>()
      .For(208.52136);  // DogBot's weight: 4 N
}

/// The fraction of a gait's cycle in which a foot stands.
double Duty(const ContactSchedule& schedule) {
  return schedule.timing.leg_stance() / schedule.timing.cycle();
}

/// A scheduler with feet that carry weight whenever they are not in the air, unless a test says otherwise.
class Walk {
 public:
  explicit Walk(Gait gait, FootSchedulerParams params = Standard()) : rig_(std::move(params)) {
    Command(gait);
  }
  void Command(Gait gait) { rig_.Fix(rig_->command, {.gait = gait, .forward = 0, .left = 0, .yaw_rate = 0}); }
  /// Force on a leg from now on, until `Free`.
  void Force(Leg leg, double newton) { forced_[leg] = newton; }
  void Free(Leg leg) { forced_[leg] = -1; }
  const ContactSchedule& Tick() {
    FootForces forces;
    for (int i = 0; i < kNumLegs; ++i) {
      const auto& leg = schedule_.legs[i];
      const bool in_air = leg.state == kSwing && leg.time_to_touchdown > 1.5e-3;
      const double forced = forced_[i];
      forces[i][2] = forced >= 0 ? forced : in_air ? 0 : 50;
    }
    rig_.Fix(rig_->foot_forces, forces).Tick();
    return schedule_ = rig_[rig_->schedule];
  }
  /// Ticks until it holds; the number of ticks, or -1 after 3 s.
  int Until(const std::function<bool(const ContactSchedule&)>& condition) {
    for (int n = 1; n <= 3000; ++n)
      if (condition(Tick())) return n;
    return -1;
  }
  const ContactSchedule& schedule() const { return schedule_; }
  ContactState state(Leg leg) const { return schedule_.legs[leg].state; }
  double time() const { return rig_.time(); }
  TestRig<FootScheduler>& rig() { return rig_; }

 private:
  TestRig<FootScheduler> rig_;
  ContactSchedule schedule_;
  std::array<double, kNumLegs> forced_{-1, -1, -1, -1};
};

std::set<int> LegsIn(const ContactSchedule& schedule, ContactState state) {
  std::set<int> legs;
  for (std::size_t i = 0; i < kNumLegs; ++i)
    if (schedule.legs[i].state == state) legs.insert(static_cast<int>(i));
  return legs;
}

TEST(NextContactStateTest, WholeTransitionTable) {
  int seen = 0;
  for (const ContactState from : {kStance, kSwing, kLate, kSearching}) {
    for (unsigned bits = 0; bits < 64; ++bits) {
      const auto bit = [&](unsigned i) { return ((bits >> i) & 1U) != 0; };
      const ContactEvents e{bit(0), bit(1), bit(2), bit(3), bit(4), bit(5)};
      // For each state the condition of being there next, as a sum of products.
      const bool stance =
          !e.lift_off && ((from == kStance && !e.unloaded) || (from == kSwing && e.loaded && e.may_land) ||
                          (from == kLate && e.loaded) || (from == kSearching && e.loaded));
      const bool swing = e.lift_off || (from == kSwing && !e.swing_over && !(e.loaded && e.may_land));
      const bool late = !e.lift_off && ((from == kSwing && e.swing_over && !(e.loaded && e.may_land)) ||
                                        (from == kLate && !e.loaded && !e.wait_over));
      const bool searching =
          !e.lift_off && ((from == kStance && e.unloaded) || (from == kLate && !e.loaded && e.wait_over) ||
                          (from == kSearching && !e.loaded));
      ASSERT_EQ(stance + swing + late + searching, 1);
      const ContactState expected = stance ? kStance : swing ? kSwing : late ? kLate : kSearching;
      EXPECT_EQ(NextContactState(from, e), expected) << EnumName(from) << ", events " << bits;
      ++seen;
    }
  }
  EXPECT_EQ(seen, 256);
}

TEST(FootSchedulerTest, StartsWithTheGroupThatLeavesTheZmpNearestToTheOthers) {
  const std::array<Eigen::Vector2d, kNumLegs> feet{{{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
  std::mt19937 generator(7);
  int others = 0;
  for (int n = 0; n < 40; ++n) {
    std::array<double, kNumLegs> force{};
    Eigen::Vector2d zmp = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      force[i] = std::uniform_real_distribution<>(10, 100)(generator);
      zmp += force[i] * feet[i];
    }
    // Distances of the ZMP from the diagonals of the front left and of the front right foot, times the
    // weight.
    const double over_left = std::abs(zmp[0] - zmp[1]) / std::sqrt(2),
                 over_right = std::abs(zmp[0] + zmp[1]) / std::sqrt(2);
    for (const double margin : {0.0, 15.0, std::numeric_limits<double>::infinity()}) {
      FootSchedulerParams params = Standard();
      params.start_margin = margin;
      Walk walk(Gait::kStand, params);
      for (const Leg leg : {kFrontLeft, kFrontRight, kRearLeft, kRearRight}) walk.Force(leg, force[leg]);
      walk.Tick();
      walk.Command(Gait::kTrot);
      ASSERT_GT(walk.Until([](const ContactSchedule& schedule) { return schedule.num_stance() < 4; }), 0);
      // The table begins with the front left foot, so that the diagonal of the front right one stays.
      const bool other = over_left / std::sqrt(2) < over_right / std::sqrt(2) - margin;
      EXPECT_EQ(walk.state(kFrontRight) == kSwing, other) << n << ", " << margin;
      others += other;
    }
  }
  EXPECT_GT(others, 20);
}

TEST(FootSchedulerTest, CrawlsFromALoadedStandWithItsLightestFoot) {
  for (const Leg light : {kFrontLeft, kFrontRight, kRearLeft, kRearRight}) {
    FootSchedulerParams params = Standard();
    params.start_margin = 5;
    Walk walk(Gait::kStand, params);
    walk.Force(light, 20);
    walk.Tick();
    walk.Command(Gait::kCrawl);
    walk.Until([](const ContactSchedule& schedule) { return schedule.num_stance() < 4; });
    EXPECT_EQ(LegsIn(walk.schedule(), kSwing), (std::set<int>{light}));
  }
}

TEST(FootSchedulerTest, EveryGaitSwingsItsGroupsInTurn) {
  const std::map<Gait, std::vector<std::set<int>>> groups{
      {Gait::kCrawl, {{kRearLeft}, {kFrontLeft}, {kRearRight}, {kFrontRight}}},
      {Gait::kTrot, {{kFrontLeft, kRearRight}, {kFrontRight, kRearLeft}}},
      {Gait::kPace, {{kFrontLeft, kRearLeft}, {kFrontRight, kRearRight}}},
      {Gait::kGallop, {{kFrontLeft, kFrontRight}, {kRearLeft, kRearRight}}}};
  for (const auto& [gait, expected] : groups) {
    Walk walk(gait);
    std::vector<std::set<int>> swings;
    std::array<int, kNumLegs> stance_ticks{};
    const double cycle = Standard().gaits[gait].Timing().cycle();
    const int ticks = static_cast<int>(std::lround(2 * cycle * 1000));
    for (int n = 0; n < ticks; ++n) {
      const auto air = LegsIn(walk.Tick(), kSwing);
      if (!air.empty() && (swings.empty() || swings.back() != air)) swings.push_back(air);
      for (std::size_t i = 0; i < kNumLegs; ++i) stance_ticks[i] += walk.schedule().legs[i].stance();
    }
    const auto steps = static_cast<int>(expected.size());
    ASSERT_EQ(swings.size(), 2 * expected.size()) << EnumName(gait);
    for (std::size_t k = 0; k < swings.size(); ++k) EXPECT_EQ(swings[k], expected[k % expected.size()]);
    for (const int count : stance_ticks)
      EXPECT_NEAR(count, ticks * walk.schedule().timing.leg_stance() / walk.schedule().timing.cycle(), 2.0)
          << EnumName(gait);
    EXPECT_EQ(walk.schedule().footsteps, 2 * steps - 1);
    walk.Tick();
    EXPECT_EQ(walk.schedule().footsteps, 2 * steps);
  }
}

TEST(FootSchedulerTest, TrotHasTheTimingOfTheThesis) {
  Walk walk(Gait::kTrot);
  walk.Tick();
  EXPECT_EQ(walk.schedule().num_stance(), 4);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.num_stance() == 2; }), 150);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.num_stance() == 4; }), 115);
  EXPECT_NEAR(Duty(walk.schedule()), 1 - 0.115 / 0.53, 1e-12);
}

TEST(FootSchedulerTest, PlannedTimesAreTheTimesAtWhichEventsCome) {
  for (const Gait gait : {Gait::kCrawl, Gait::kTrot}) {
    for (const Leg leg : {kFrontLeft, kFrontRight, kRearLeft, kRearRight}) {
      Walk walk(gait);
      for (int n = 0; n < 431; ++n) walk.Tick();
      const LegContact planned = walk.schedule().legs[leg];
      const double now = walk.time();
      const ContactState state = planned.state;
      ASSERT_GE(walk.Until([&](const auto& s) { return s.legs[leg].state != state; }), 0);
      const double first = walk.time() - now;
      ASSERT_GE(walk.Until([&](const auto& s) { return s.legs[leg].state == state; }), 0);
      const double second = walk.time() - now;
      const bool stance = state == kStance;
      EXPECT_NEAR(stance ? planned.time_to_lift_off : planned.time_to_touchdown, first, 1.1e-3);
      EXPECT_NEAR(stance ? planned.time_to_touchdown : planned.time_to_lift_off, second, 1.1e-3);
    }
  }
}

TEST(FootSchedulerTest, PhasesRunFromZeroToOne) {
  Walk walk(Gait::kTrot);
  walk.Until([](const auto& s) { return s.legs[kFrontLeft].state == kSwing; });
  EXPECT_NEAR(walk.schedule().legs[kFrontLeft].phase, 0, 1e-9);
  walk.Until([](const auto& s) { return s.step_time > 0.15 + 0.115 / 2 - 1e-9; });
  EXPECT_NEAR(walk.schedule().legs[kFrontLeft].phase, 0.5, 0.01);
  walk.Until([](const auto& s) { return s.footsteps == 1; });
  EXPECT_NEAR(walk.schedule().legs[kFrontLeft].phase, 0, 1e-9);
  EXPECT_NEAR(walk.schedule().legs[kFrontRight].phase, 1 - 0.15 / 0.415, 1e-9);
}

TEST(FootSchedulerTest, TouchdownCountsAfterHalfTheSwingAndDoesNotShortenTheStep) {
  Walk walk(Gait::kTrot);
  walk.Until([](const auto& s) { return s.num_stance() == 2; });
  walk.Force(kFrontLeft, 100);  // the force that it still carries as it lifts off
  EXPECT_EQ(walk.Until([](const auto& s) { return s.legs[kFrontLeft].stance(); }), 58);  // of 115
  EXPECT_EQ(walk.state(kRearRight), kSwing);
  EXPECT_EQ(walk.schedule().footsteps, 0);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.footsteps == 1; }), 115 - 58);
  EXPECT_EQ(walk.schedule().num_stance(), 4);
}

TEST(FootSchedulerTest, ForceBelowTheThresholdIsNoTouchdown) {
  Walk walk(Gait::kTrot);
  walk.Until([](const auto& s) { return s.num_stance() == 2; });
  walk.Force(kFrontLeft, 3.9);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.legs[kFrontLeft].state == kLate; }), 115);
  walk.Force(kFrontLeft, 4.1);
  walk.Tick();
  EXPECT_EQ(walk.state(kFrontLeft), kStance);
}

TEST(FootSchedulerTest, ClockWaitsForALateFoot) {
  Walk walk(Gait::kTrot);
  walk.Until([](const auto& s) { return s.num_stance() == 2; });
  walk.Force(kFrontLeft, 0);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.legs[kFrontLeft].state == kLate; }), 115);
  EXPECT_EQ(walk.state(kRearRight), kStance);
  for (int n = 0; n < 100; ++n) {
    walk.Tick();
    ASSERT_EQ(walk.state(kFrontLeft), kLate);
    ASSERT_EQ(walk.schedule().footsteps, 0);
    ASSERT_NEAR(walk.schedule().step_time, 0.265, 1e-9);
    ASSERT_EQ(walk.schedule().legs[kFrontLeft].time_to_touchdown, 0);
  }
  walk.Free(kFrontLeft);
  walk.Tick();
  EXPECT_EQ(walk.state(kFrontLeft), kStance);
  EXPECT_EQ(walk.schedule().footsteps, 1);
  EXPECT_EQ(walk.schedule().step_time, 0);
}

TEST(FootSchedulerTest, ClockGoesOnAfterItsLimitAndTheFootSearches) {
  Walk walk(Gait::kTrot);
  walk.Until([](const auto& s) { return s.num_stance() == 2; });
  walk.Force(kFrontLeft, 0);
  walk.Until([](const auto& s) { return s.legs[kFrontLeft].state == kLate; });
  EXPECT_EQ(walk.Until([](const auto& s) { return s.footsteps == 1; }), 250);
  EXPECT_EQ(walk.state(kFrontLeft), kSearching);
  walk.Free(kFrontLeft);
  walk.Tick();
  EXPECT_EQ(walk.state(kFrontLeft), kStance);
}

TEST(FootSchedulerTest, AFootThatNeverFindsGroundStillSwingsInItsTurn) {
  Walk walk(Gait::kTrot);
  walk.Tick();
  walk.Force(kFrontLeft, 0);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.legs[kFrontLeft].state == kSearching; }), 12);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.legs[kFrontLeft].state == kSwing; }), 150 - 12);
}

TEST(FootSchedulerTest, StanceFootWithoutForceSearches) {
  for (const Gait gait : {Gait::kStand, Gait::kTrot}) {
    Walk walk(gait);
    for (int n = 0; n < 20; ++n) walk.Tick();
    walk.Force(kRearLeft, 0);
    for (int n = 0; n < 11; ++n) walk.Tick();
    EXPECT_EQ(walk.state(kRearLeft), kStance);
    walk.Free(kRearLeft);
    walk.Tick();  // the count begins anew
    walk.Force(kRearLeft, 0);
    EXPECT_EQ(walk.Until([](const auto& s) { return s.legs[kRearLeft].state == kSearching; }), 12);
    EXPECT_EQ(walk.schedule().legs[kRearLeft].time_to_touchdown, 0);
    walk.Free(kRearLeft);
    walk.Tick();
    EXPECT_EQ(walk.state(kRearLeft), kStance);
  }
}

// While the front right foot searches for ground, its diagonal partner would carry the robot alone.
TEST(FootSchedulerTest, NoLegLiftsOffWhileOneThatStaysSearches) {
  const auto lifts_off = [](const ContactSchedule& s) { return s.legs[kFrontLeft].state == kSwing; };
  const auto searches = [](const ContactSchedule& s) { return s.legs[kFrontRight].state == kSearching; };
  Walk found(Gait::kTrot), lost(Gait::kTrot), same_pair(Gait::kTrot);
  for (Walk* walk : {&found, &lost}) {
    walk->Force(kFrontRight, 0);
    ASSERT_GT(walk->Until(searches), 0);
  }
  ASSERT_EQ(LegsIn(found.schedule(), kSwing), std::set<int>());
  while (found.time() < 0.2) EXPECT_FALSE(lifts_off(found.Tick())) << found.time();
  EXPECT_NEAR(found.schedule().legs[kFrontLeft].time_to_lift_off, 0, 1e-12);
  found.Free(kFrontRight);
  EXPECT_EQ(found.Until(lifts_off), 1) << "there is the ground";

  // At most as long as for a late foot: 0.15 s of stance and 0.25 s.
  ASSERT_GT(lost.Until(lifts_off), 0);
  EXPECT_NEAR(lost.time(), 0.15 + Standard().late_wait, 3e-3);

  same_pair.Force(kRearRight, 0);  // which is to swing
  ASSERT_GT(same_pair.Until(lifts_off), 0);
  EXPECT_NEAR(same_pair.time(), 0.15, 3e-3);
}

TEST(FootSchedulerTest, GaitsChangeAtTheBeginningOfAStep) {
  Walk walk(Gait::kTrot);
  for (int n = 0; n < 200; ++n) walk.Tick();
  walk.Command(Gait::kPace);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.gait == Gait::kPace; }), 266 - 200);
  EXPECT_EQ(walk.schedule().num_stance(), 4);
  EXPECT_EQ(walk.schedule().step, 0);
  EXPECT_EQ(walk.schedule().footsteps, 1);
  walk.Until([](const auto& s) { return s.num_stance() == 2; });
  EXPECT_THAT(LegsIn(walk.schedule(), kSwing), testing::ElementsAre(kFrontLeft, kRearLeft));

  walk.Command(Gait::kStand);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.gait == Gait::kStand; }), 115);
  EXPECT_EQ(walk.schedule().footsteps, 2);
  EXPECT_EQ(walk.schedule().timing.num_steps, 0);
  for (int n = 0; n < 500; ++n) ASSERT_EQ(walk.Tick().num_stance(), 4);
  EXPECT_EQ(walk.schedule().footsteps, 2);
  EXPECT_EQ(walk.schedule().legs[0].time_to_lift_off, 0);

  walk.Command(Gait::kCrawl);
  walk.Tick();
  EXPECT_EQ(walk.schedule().gait, Gait::kCrawl);
  EXPECT_EQ(walk.schedule().footsteps, 3);
  EXPECT_EQ(walk.Until([](const auto& s) { return s.num_stance() == 3; }), 50);
}

TEST(FootSchedulerTest, WithoutStanceTheGroupsFollowAtOnce) {
  FootSchedulerParams params = Standard();
  params.gaits.trot.stance = 0;
  Walk walk(Gait::kTrot, params);
  for (int n = 0; n < 400; ++n) ASSERT_EQ(walk.Tick().num_stance(), 2) << n;
  EXPECT_EQ(Duty(walk.schedule()), 0.5);
  EXPECT_EQ(walk.schedule().footsteps, 3);
}

/// The gaits of standard.yaml, the trot with 0.04 s of flight: each pair stands for 0.12 s.
FootSchedulerParams Flying() {
  FootSchedulerParams params = Standard();
  params.gaits.trot.stance = -0.04;
  params.gaits.trot.swing = 0.2;
  return params;
}

TEST(FootSchedulerTest, NegativeStanceIsAFlight) {
  Walk walk(Gait::kTrot, Flying());
  std::map<int, int> ticks;  // by the number of feet in stance
  double planned = 0;
  for (int n = 0; n < 1680; ++n) {  // four cycles count
    const ContactSchedule& schedule = walk.Tick();
    if (n < 400) continue;
    ++ticks[schedule.num_stance()];
    const LegContact& leg = schedule.legs[kFrontLeft];
    if (leg.state == kSwing) {
      if (planned > 0) EXPECT_NEAR(leg.time_to_touchdown, planned - 1e-3, 1e-9);
      planned = leg.time_to_touchdown;
    } else {
      planned = 0;
    }
  }
  // A cycle of 0.32 s has two flights and two stances of a pair.
  EXPECT_NEAR(ticks[0], 1280 * 0.08 / 0.32, 16);
  EXPECT_NEAR(ticks[2], 1280 * 0.24 / 0.32, 16);
  EXPECT_EQ(ticks[4] + ticks[1] + ticks[3], 0);
}

TEST(FootSchedulerTest, AGaitWithFlightEndsOnTheGround) {
  for (int ticks = 1000; ticks < 1320; ticks += 20) {
    Walk walk(Gait::kTrot, Flying());
    for (int n = 0; n < ticks; ++n) walk.Tick();
    walk.Command(Gait::kStand);
    const int wait = walk.Until([](const ContactSchedule& s) { return s.gait == Gait::kStand; });
    EXPECT_GT(wait, 0);
    EXPECT_LE(wait, 322);
    EXPECT_EQ(walk.schedule().num_stance(), 4) << ticks;
  }
}

/// Rear feet, then front feet, the left one before the right one.
FootSchedulerParams Galloping() {
  FootSchedulerParams params = Standard();
  params.gaits.gallop = {{{kRearLeft, kRearRight}, {kFrontLeft, kFrontRight}},
                         /*stance=*/-0.09,
                         /*swing=*/0.2,
                         /*stagger=*/0.03};
  return params;
}

TEST(FootSchedulerTest, StaggeredLegsGallopWithFourBeats) {
  Walk walk(Gait::kGallop, Galloping());
  std::vector<std::pair<int, Leg>> beats;  // tick of a touchdown and its leg
  std::map<int, int> ticks;                // by the number of feet in stance
  std::array<ContactState, kNumLegs> before{};
  for (int n = 0; n < 400 + 4 * 280; ++n) {
    const ContactSchedule& schedule = walk.Tick();
    for (const Leg leg : {kFrontLeft, kFrontRight, kRearLeft, kRearRight}) {
      const ContactState now = schedule.legs[leg].state;
      if (n >= 400 && now == kStance && before[leg] == kSwing) beats.emplace_back(n, leg);
      before[leg] = now;
    }
    if (n >= 400) ++ticks[schedule.num_stance()];
  }
  // A cycle takes 2 (0.2 + 0.03 - 0.09) s. A foot stands for 0.08 s of it, and two flights of 0.03 s remain.
  ASSERT_EQ(beats.size(), 16U);
  const std::map<Leg, std::pair<Leg, int>> next{{kRearLeft, {kRearRight, 30}},
                                                {kRearRight, {kFrontLeft, 110}},
                                                {kFrontLeft, {kFrontRight, 30}},
                                                {kFrontRight, {kRearLeft, 110}}};
  for (std::size_t k = 0; k + 1 < beats.size(); ++k) {
    const auto& [leg, wait] = next.at(beats[k].second);
    EXPECT_EQ(beats[k + 1].second, leg);
    EXPECT_NEAR(beats[k + 1].first - beats[k].first, wait, 2);
  }
  EXPECT_NEAR(ticks[0], 4 * 60, 16);
  EXPECT_NEAR(ticks[1], 4 * 120, 16);
  EXPECT_NEAR(ticks[2], 4 * 100, 16);
}

TEST(FootSchedulerTest, StaggeredLegsLandWhenTheirPlanSays) {
  for (const double stance : {-0.09, -0.02, 0.05}) {
    FootSchedulerParams params = Galloping();
    params.gaits.gallop.stance = stance;
    Walk walk(Gait::kGallop, params);
    for (int n = 0; n < 500; ++n) walk.Tick();
    for (const Leg leg : {kFrontLeft, kFrontRight, kRearLeft, kRearRight}) {
      ASSERT_GT(walk.Until([&](const ContactSchedule& s) { return s.legs[leg].stance(); }), 0);
      ASSERT_GT(walk.Until([&](const ContactSchedule& s) { return s.legs[leg].state == kSwing; }), 0);
      EXPECT_NEAR(walk.schedule().legs[leg].phase, 0, 1e-2);
      EXPECT_NEAR(walk.schedule().legs[leg].time_to_touchdown, 0.2, 2e-3);
      EXPECT_NEAR(walk.Until([&](const ContactSchedule& s) { return s.legs[leg].stance(); }), 200, 3)
          << stance;
    }
    walk.Command(Gait::kStand);
    EXPECT_LE(walk.Until([](const ContactSchedule& s) { return s.gait == Gait::kStand; }), 600);
    EXPECT_EQ(walk.schedule().num_stance(), 4);
  }
}

TEST(FootSchedulerTest, ASingleGroupJumps) {
  FootSchedulerParams params = Standard();
  params.gaits.trot.swing_groups = {{kFrontLeft, kFrontRight, kRearLeft, kRearRight}};
  Walk walk(Gait::kTrot, params);
  EXPECT_GT(walk.Until([](const ContactSchedule& s) { return s.num_stance() == 0; }), 0);
  EXPECT_NEAR(walk.Until([](const ContactSchedule& s) { return s.num_stance() == 4; }), 115, 2);
}

TEST(FootSchedulerTest, RefusesNonsense) {
  const auto refuses = RefusesChanged<FootScheduler>(Standard());
  EXPECT_TRUE(refuses([](auto& p) { p.gaits.trot.stance = -1; }, "gaits.trot", "stance_s"));
  EXPECT_TRUE(
      refuses([](auto& p) { p.gaits.crawl.swing_groups.pop_back(); }, "gaits.crawl", "'front_right'"));
  EXPECT_TRUE(refuses([](auto& p) { p.gaits.gallop.swing_groups[0].clear(); }, "gaits.gallop"));
  EXPECT_TRUE(refuses(
      [](auto& p) {
        p.gaits.trot.swing_groups = {{kFrontLeft, kFrontRight, kRearLeft, kRearRight}};
        p.gaits.trot.stance = 0;
      },
      "gaits.trot", "never stand"));
  EXPECT_TRUE(Throws<Error>([] { GaitTable()[Gait::kStand]; }, "stand"));
}

TEST(FootSchedulerTest, FileErrorsNameThePlace) {
  auto document = YamlDocument::Load(TENON_GAITS_DIR "/standard.yaml");
  document.Set("gaits.trot.swing_groups", "[[front_left, rear_rigth], [front_right, rear_left]]");
  EXPECT_TRUE(Throws<ParameterError>([&] { document.Read<GaitFile>(); }, "gaits.trot.swing_groups",
                                     "rear_rigth", "rear_right"));
  document.Set("gaits.trot.swing_groups", "[[front_left], [front_right, rear_left]]");
  EXPECT_TRUE(Throws<ParameterError>([&] { document.Read<GaitFile>(); }, "gaits.trot", "'rear_right'"));
  auto heavy = YamlDocument::Load(TENON_GAITS_DIR "/standard.yaml");
  heavy.Set("touchdown_force_mg", "4");
  EXPECT_TRUE(Throws<ParameterError>([&] { heavy.Read<GaitFile>(); }, "touchdown_force_mg"));
}

TEST(FootSchedulerTest, LimitsAndGaitsAreSetInARun) {
  FootSchedulerParams changed = Standard();
  changed.gaits.trot.swing *= 1.5;
  changed.touchdown_force = 60;  // more than the feet carry
  changed.early_touchdown_phase = 0.2;
  changed.late_wait = 0.02;
  changed.search_after = 0.2;
  Walk plain(Gait::kTrot), set(Gait::kTrot), built(Gait::kTrot, changed);
  auto& block = set.rig().system();
  set.rig().Set(block.gaits, changed.gaits).Set(block.touchdown_force, changed.touchdown_force);
  set.rig().Set(block.early_touchdown_phase, changed.early_touchdown_phase);
  set.rig().Set(block.late_wait, changed.late_wait).Set(block.search_after, changed.search_after);
  bool differs = false;
  const auto numbers = [](Walk& walk) {
    walk.Tick();
    return walk.rig().context().EvalDoubles(walk.rig()->schedule);
  };
  for (int n = 0; n < 1500; ++n) {
    const std::vector<double> expected = numbers(built);
    ASSERT_EQ(numbers(set), expected) << n;
    differs = differs || numbers(plain) != expected;
  }
  EXPECT_TRUE(differs);
}

// A trot swings for 0.115 s after 0.15 s of stance.
TEST(FootSchedulerTest, TheClockRateShortensSwingsAloneAndTheNextStepIsAsPlanned) {
  Walk walk(Gait::kTrot), hasty(Gait::kTrot);
  const auto swings = [](const ContactSchedule& schedule) { return !LegsIn(schedule, kSwing).empty(); };
  const auto stands = [](const ContactSchedule& schedule) { return schedule.num_stance() == kNumLegs; };
  hasty.rig().Fix(hasty.rig()->clock_rate, 2);
  EXPECT_EQ(hasty.Until(swings), walk.Until(swings));
  double phase = 0;
  int ticks = 0;
  for (; swings(hasty.Tick()); ++ticks) {
    EXPECT_LE(hasty.schedule().legs[kFrontLeft].phase - phase, 2e-3 / 0.115 + 1e-9);  // continuous
    phase = hasty.schedule().legs[kFrontLeft].phase;
  }
  EXPECT_NEAR(ticks, 115 / 2, 1);
  hasty.rig().Fix(hasty.rig()->clock_rate, 1);
  walk.Until(stands);
  EXPECT_EQ(hasty.Until(swings), walk.Until(swings));
  EXPECT_EQ(hasty.Until(stands), walk.Until(stands));
}

TEST(FootSchedulerTest, TheClockRateLeavesFlightAlone) {
  const FootSchedulerParams flight =
      YamlDocument::Load(TENON_GAITS_DIR "/flight.yaml").Read<GaitFile>().For(208.52136);
  Walk walk(Gait::kTrot, flight), hasty(Gait::kTrot, flight);
  hasty.rig().Fix(hasty.rig()->clock_rate, 2);
  for (int n = 0; n < 500; ++n) EXPECT_EQ(hasty.Tick().step_time, walk.Tick().step_time) << n;
}

// A gait keeps its timing until it begins the next time.
TEST(FootSchedulerTest, ANewTimingCountsFromTheNextBeginningOfTheGait) {
  Walk walk(Gait::kTrot);
  const double swing = walk.Tick().timing.swing;
  GaitTable gaits = Standard().gaits;
  gaits.trot.swing = 2 * swing;
  walk.rig().Set(walk.rig()->gaits, gaits);
  for (int n = 0; n < 1000; ++n) EXPECT_EQ(walk.Tick().timing.swing, swing);
  walk.Command(Gait::kStand);
  walk.Until([](const ContactSchedule& schedule) { return schedule.gait == Gait::kStand; });
  walk.Command(Gait::kTrot);
  walk.Tick();
  EXPECT_EQ(walk.Tick().timing.swing, 2 * swing);
}

constexpr StepTiming kTiming{.lookahead = 0.1, .free_tilt = 0.3, .clock_rate = 2};

/// Two ticks with this attitude and angular velocity against this reference; the second one has the output.
double ClockRate(const Vec<4>& q_WB, const Vec<3>& w_W, const BodyReference& body = {},
                 const StepTiming& timing = kTiming) {
  TestRig<StepTimingAdapter> rig({.timing = timing});
  rig.Fix(rig->state, {.q_WB = q_WB, .w_W = w_W}).Fix(rig->body, body);
  EXPECT_EQ(rig.Tick()[rig->clock_rate], 1) << "before the first update";
  return rig.Tick()[rig->clock_rate];
}
Vec<4> Tilted(double angle, double yaw = 0) {
  return QuaternionProduct(QuaternionFromEuler({0, 0, yaw}), QuaternionFromRotationVector({angle, 0, 0}));
}

TEST(StepTimingAdapterTest, SwingsAreFasterWhileThePredictedTiltIsLarge) {
  EXPECT_EQ(ClockRate(Tilted(0), {0, 0, 0}), 1);
  EXPECT_EQ(ClockRate(Tilted(std::asin(0.299)), {0, 0, 0}), 1);
  EXPECT_EQ(ClockRate(Tilted(std::asin(0.301)), {0, 0, 0}), 2);
  EXPECT_EQ(ClockRate(Tilted(0), {0, -2.99, 0}), 1);
  EXPECT_EQ(ClockRate(Tilted(0), {0, -3.01, 0}), 2);
  EXPECT_EQ(ClockRate(Tilted(0.2), {1.1, 0, 0}), 2);  // falls further
  EXPECT_EQ(ClockRate(Tilted(0.2), {-4, 0, 0}), 1);   // rises, and is level in 50 ms
  EXPECT_EQ(ClockRate(Tilted(0, 2), {0, 0, 50}), 1);  // a turn is no fall
}

// The trunk is parallel to a slope, turned, and follows the rates of its reference.
TEST(StepTimingAdapterTest, TiltAndRateCountFromTheReference) {
  const BodyReference body{.q_WB = QuaternionProduct(Tilted(0.5), QuaternionFromEuler({0, 0, 1})),
                           .w_W = {0, 4, 0}};
  EXPECT_EQ(ClockRate(Tilted(0.5), body.w_W, body), 1);
  EXPECT_EQ(ClockRate(Tilted(0.5), {0, 0, 0}, body), 2);
  EXPECT_EQ(ClockRate(Tilted(0), body.w_W, body), 2);
}

}  // namespace tenon::foot_scheduler_test
