// The CoM planner with splines whose ZMP is optimised, behind the foot scheduler, without a plant.

#include <tenon/controllers/legged/planning/com_planner.h>
#include <tenon/controllers/legged/planning/foot_scheduler.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <tuple>

namespace tenon::com_planner_spline_test {

ComPlannerParams SplineParams(SplineOrder order = SplineOrder::kCubic) {
  ComPlannerParams params{.robot = test::DogBot(), .reference = ComReference::kZmpSpline};
  params.zmp.spline.order = order;
  return params;
}

/// A walk by the foot scheduler, its feet pressing as soon as they are expected on the ground.
class ScheduledWalk {
 public:
  explicit ScheduledWalk(const ComPlannerParams& params)
      : scheduler_(YamlDocument::Load(TENON_GAITS_DIR "/standard.yaml").Read<GaitFile>().For(208.5)),
        planner_(params) {}

  void Command(Gait gait, double forward, double left = 0, double yaw_rate = 0) {
    command_ = {gait, forward, left, yaw_rate};
  }
  /// Keeps the foot off the ground from now on, or lets it land.
  void HoldUp(int leg, bool up) { up_[leg] = up; }
  void Tick() {
    FootForces forces;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const LegContact& contact = schedule_.legs[leg];
      const bool swings = contact.state == ContactState::kSwing && contact.phase < 0.99;
      forces[leg][2] = swings || up_[leg] ? 0 : 50;
    }
    scheduler_.Fix(scheduler_->command, command_).Fix(scheduler_->foot_forces, forces).Tick();
    schedule_ = scheduler_[scheduler_->schedule];
    planner_.Fix(planner_->schedule, schedule_).Fix(planner_->command, command_);
    planner_.Fix(planner_->ground, GroundPlane()).Tick();
  }
  const ContactSchedule& schedule() const { return schedule_; }
  BodyReference reference() { return planner_[planner_->reference]; }
  PlanarPath path() { return planner_[planner_->path]; }
  ComDiagnostics diagnostics() { return planner_[planner_->diagnostics]; }
  const ComPlan& plan() { return planner_[planner_->plan]; }
  ComPlanner& system() { return planner_.system(); }
  TestRig<ComPlanner>& rig() { return planner_; }
  Eigen::Vector2d Zmp() {
    const BodyReference r = reference();
    return r.com_W.head<2>() - system().stance.com_height / 9.81 * r.com_acceleration_W.head<2>();
  }

 private:
  TestRig<FootScheduler> scheduler_;
  TestRig<ComPlanner> planner_;
  ContactSchedule schedule_;
  WalkCommand command_;
  std::array<bool, kNumLegs> up_{};
};

class SplineWalk : public ::testing::TestWithParam<std::tuple<Gait, SplineOrder>> {};
INSTANTIATE_TEST_SUITE_P(Gaits, SplineWalk,
                         ::testing::Combine(::testing::Values(Gait::kCrawl, Gait::kTrot, Gait::kPace,
                                                              Gait::kGallop),
                                            ::testing::Values(SplineOrder::kCubic, SplineOrder::kQuintic)),
                         [](const auto& info) {
                           return std::string(EnumName(std::get<0>(info.param))) + "_" +
                                  EnumName(std::get<1>(info.param));
                         });

/// From standing to a walk along an arc and back to standing: nothing jumps, accelerations included while
/// it walks, and the ZMP is above the line or in the triangle of the feet that are planned to stand.
TEST_P(SplineWalk, KeepsTheZmpOverTheFeetAndNothingJumps) {
  const auto [gait, order] = GetParam();
  const ComPlannerParams params = SplineParams(order);
  ScheduledWalk walk(params);
  walk.Tick();
  BodyReference last = walk.reference();
  const double dt = 1e-3;
  double least = 1, farthest = 0;
  int checked = 0;
  std::array<Eigen::Vector2d, kNumLegs> foot;
  for (std::size_t i = 0; i < kNumLegs; ++i) foot[i] = walk.path().position_W + walk.system().stance.foot[i];
  for (int n = 1; n < 8000; ++n) {
    if (n == 400) walk.Command(gait, 0.12, 0.02, 0.1);
    if (n == 6500) walk.Command(Gait::kStand, 0);
    walk.Tick();
    const BodyReference now = walk.reference();
    EXPECT_THAT(now.com_W - last.com_W, IsNear(dt / 2 * (now.com_velocity_W + last.com_velocity_W), 3e-6));
    EXPECT_THAT(now.com_velocity_W - last.com_velocity_W,
                IsNear(dt / 2 * (now.com_acceleration_W + last.com_acceleration_W), 4e-3));
    farthest = std::max(farthest, (now.com_W.head<2>() - walk.path().position_W).norm());
    const ContactSchedule& schedule = walk.schedule();
    if (schedule.gait != Gait::kStand) {
      EXPECT_THAT(now.com_acceleration_W, IsNear(last.com_acceleration_W, 0.35)) << n;
      // Footholds from the definition of the nominal walk, independently of the planner.
      std::vector<Eigen::Vector2d> standing;
      for (std::size_t i = 0; i < kNumLegs; ++i) {
        const LegContact& leg = schedule.legs[i];
        if (!leg.stance()) continue;
        const PlanarPath there = walk.path().At(leg.time_to_lift_off - schedule.timing.leg_stance() / 2);
        standing.push_back(there.position_W + there.Heading() * walk.system().stance.foot[i]);
      }
      if (standing.size() < 4 && n > 1500) {
        const SupportPolygon polygon(standing, params.zmp.half_width, params.zmp.margin);
        least = std::min(least, polygon.Depth(walk.Zmp()));
        ++checked;
      }
    }
    last = now;
  }
  EXPECT_EQ(walk.diagnostics().failures, 0);
  EXPECT_GT(walk.diagnostics().solves, 20);
  EXPECT_GT(checked, 1000);
  EXPECT_GT(least, -1.5e-3);
  EXPECT_LT(farthest, 0.1);
  EXPECT_LT(last.com_velocity_W.norm(), 1e-12);
}

TEST(ComPlannerSpline, IsPlannedAtFootstepsOnlyAndGoesOnThroughAWait) {
  ScheduledWalk walk(SplineParams());
  walk.Tick();
  walk.Command(Gait::kTrot, 0.12);
  BodyReference last = walk.reference();
  for (int n = 1; n < 4000; ++n) {
    if (n == 1000) walk.HoldUp(kFrontLeft, true);
    if (n == 1300) walk.HoldUp(kFrontLeft, false);
    const int footsteps = walk.schedule().footsteps;
    const long solves = walk.diagnostics().solves;
    walk.Tick();
    EXPECT_EQ(walk.diagnostics().solves - solves, walk.schedule().footsteps - footsteps) << n;
    const BodyReference now = walk.reference();
    EXPECT_THAT(now.com_W - last.com_W, IsNear(5e-4 * (now.com_velocity_W + last.com_velocity_W), 3e-6)) << n;
    last = now;
  }
  EXPECT_EQ(walk.diagnostics().failures, 0);
}

/// Gaits and speeds change at the beginnings of steps: nothing jumps, and where no spline is found one is
/// found at a later footstep.
TEST(ComPlannerSpline, GaitsAndSpeedsChange) {
  ScheduledWalk walk(SplineParams());
  walk.Tick();
  BodyReference last = walk.reference();
  const std::array<Gait, 8> gaits{Gait::kTrot, Gait::kPace,  Gait::kCrawl, Gait::kGallop,
                                  Gait::kPace, Gait::kCrawl, Gait::kTrot,  Gait::kStand};
  for (int n = 1; n < 16000; ++n) {
    const int k = n / 2000;
    if (n % 2000 == 1) walk.Command(gaits[k], k == 7 ? 0 : 0.1 + 0.1 * (k % 3), 0, k % 2 == 0 ? 0.2 : -0.2);
    walk.Tick();
    const BodyReference now = walk.reference();
    EXPECT_THAT(now.com_W - last.com_W, IsNear(5e-4 * (now.com_velocity_W + last.com_velocity_W), 3e-6)) << n;
    EXPECT_THAT(now.com_velocity_W - last.com_velocity_W,
                IsNear(5e-4 * (now.com_acceleration_W + last.com_acceleration_W), 5e-3))
        << n;
    EXPECT_LT((now.com_W.head<2>() - walk.path().position_W).norm(), 0.1) << n;
    if (n % 2000 == 1999) {
      EXPECT_EQ(walk.diagnostics().failures_in_a_row, 0) << n;
    }
    last = now;
  }
  EXPECT_LE(walk.diagnostics().failures, 2) << "of " << walk.diagnostics().solves;
}

TEST(ComPlannerSpline, OfATrotOnTheSpotRests) {
  ScheduledWalk walk(SplineParams());
  walk.Tick();
  walk.Command(Gait::kTrot, 0);
  for (int n = 0; n < 8000; ++n) walk.Tick();
  EXPECT_THAT(walk.reference().com_W.head<2>(), IsNear(walk.path().position_W, 1e-6));
  EXPECT_LT(walk.reference().com_acceleration_W.norm(), 1e-4);
}

/// If the margin leaves nothing of the polygon, no spline exists and the old plan, here the stand, goes on.
TEST(ComPlannerSpline, KeepsTheOldPlanAndCountsIfThereIsNoNewOne) {
  ComPlannerParams params = SplineParams();
  params.zmp.margin = 0.3;
  ScheduledWalk walk(params);
  for (int n = 0; n < 600; ++n) walk.Tick();
  const BodyReference stand = walk.reference();
  EXPECT_EQ(walk.diagnostics().solves, 0);
  walk.Command(Gait::kTrot, 0.2);
  for (int n = 0; n < 1000; ++n) walk.Tick();
  EXPECT_EQ(walk.reference().com_W, stand.com_W);
  EXPECT_EQ(walk.path().velocity.norm(), 0);
  EXPECT_EQ(walk.diagnostics().solves, 4);
  EXPECT_EQ(walk.diagnostics().failures, 4);
  EXPECT_EQ(walk.diagnostics().failures_in_a_row, 4);
  EXPECT_EQ(walk.diagnostics().status, QpStatus::kInfeasible);
  EXPECT_GE(walk.diagnostics().constraint, 0);
}

/// If there is no spline from the first tick on, the initial reference stays.
TEST(ComPlannerSpline, StandsStillIfThereIsNoFirstOne) {
  ComPlannerParams params = SplineParams();
  params.zmp.margin = 0.3;
  params.robot.trunk.com[0] += 0.03;
  ScheduledWalk walk(params);
  walk.Command(Gait::kTrot, 0.2);
  walk.Tick();
  const BodyReference first = walk.reference();
  for (int n = 0; n < 1000; ++n) {
    walk.Tick();
    ASSERT_EQ(walk.reference().com_W, first.com_W) << n;
  }
  EXPECT_GT(walk.diagnostics().failures, 2);
}

TEST(ComPlannerSpline, DoesNotAllocate) {
  ScheduledWalk walk(SplineParams());
  walk.Tick();
  walk.Command(Gait::kTrot, 0.12);
  walk.Tick();
  const AllocationGuard guard;
  for (int n = 0; n < 1000; ++n) walk.Tick();
  EXPECT_EQ(guard.count(), 0);
}

TEST(ComPlannerSpline, ThePlanIsSetInARun) {
  ComPlannerParams changed = SplineParams(SplineOrder::kQuintic);
  changed.zmp.horizon = 3;
  changed.zmp.margin = 0.005;
  changed.zmp.spline.path_weight = 40;
  const auto walk_off = [](ScheduledWalk& walk) {
    walk.Command(Gait::kTrot, 0.1);
    for (int n = 0; n < 700; ++n) walk.Tick();
    return walk.reference();
  };
  ScheduledWalk plain(SplineParams()), set(SplineParams()), built(changed);
  set.rig().Set(set.rig()->zmp, changed.zmp);
  const BodyReference expected = walk_off(built), found = walk_off(set);
  EXPECT_EQ(found.com_W, expected.com_W);
  EXPECT_EQ(found.com_acceleration_W, expected.com_acceleration_W);
  EXPECT_NE(walk_off(plain).com_acceleration_W, expected.com_acceleration_W);
  EXPECT_TRUE(
      Throws<ParameterError>([&] { set.rig().Set(set.rig()->zmp, {.horizon = 5}); }, "horizon_steps"));
}

}  // namespace tenon::com_planner_spline_test
