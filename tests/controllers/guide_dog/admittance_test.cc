#include <tenon/controllers/guide_dog/admittance_filter.h>
#include <tenon/controllers/guide_dog/reference_admittance.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::admittance_test {

constexpr double kForward = 0.12;
const WalkCommand kTrot{.gait = Gait::kTrot, .forward = kForward, .left = 0, .yaw_rate = 0.1};

AdmittanceGains Unlimited() {
  return {.min_forward = 0, .max_forward = 1e9, .max_left = 1e9, .acceleration = 1e9};
}

class Filter {
 public:
  explicit Filter(const AdmittanceGains& gains = {}) : rig_(AdmittanceFilterParams{gains}) {
    Command(kTrot);
    Force({-30, 0, 0});
  }
  void Command(const WalkCommand& command) { rig_.Fix(rig_->command, command); }
  /// On the robot, in the frame of the heading.
  void Force(const Vec<3>& force, double yaw = 0) {
    rig_.Fix(rig_->state, {.q_WB = QuaternionFromRotation(RotationFromEuler({0.02, -0.05, yaw}))})
        .Fix(rig_->wrench, {.force_W = RotationFromEuler({0, 0, yaw}) * force});
  }
  const AdmittanceMotion& Tick() { return rig_.Tick()[rig_->motion]; }
  const AdmittanceMotion& Run(int ticks) {
    for (int i = 1; i < ticks; ++i) Tick();
    return Tick();
  }
  const WalkCommand& walk() { return rig_[rig_->walk]; }
  TestRig<AdmittanceFilter>& rig() { return rig_; }

 private:
  TestRig<AdmittanceFilter> rig_;
};

TEST(AdmittanceFilterTest, AtTheDesiredTensionTheCommandPasses) {
  Filter filter;
  filter.Run(1000);
  EXPECT_NEAR(filter.walk().forward, kForward, 1e-12);
  EXPECT_EQ(filter.walk().left, 0);
  EXPECT_EQ(filter.walk().yaw_rate, 0.1);
  EXPECT_EQ(filter.walk().gait, Gait::kTrot);
}

// M v' + D v = f_d - T from rest: v = (f_d - T) / D (1 - exp(-D t / M)).
TEST(AdmittanceFilterTest, AlongThePathIsAMassWithDamping) {
  AdmittanceGains params = Unlimited();
  params.mass = {8, 3};
  params.damping = {40, 7};
  const double damping = params.damping[0];
  Filter filter(params);
  filter.Run(2);
  filter.Force({-32, 0, 0});
  for (int n = 1; n <= 100; ++n) {
    const AdmittanceMotion& motion = filter.Tick();
    const double t = 0.01 * n;
    const double v = (30 - 32) / damping * (1 - std::exp(-damping / params.mass[0] * t));
    EXPECT_NEAR(motion.tension, 32, 1e-12);
    EXPECT_NEAR(motion.correction[0], v, 1e-12) << n;
    EXPECT_NEAR(filter.walk().forward, kForward + v, 1e-12) << n;
    EXPECT_NEAR(motion.correction[1], 0, 1e-12);
  }
}

// M y'' + D y' + K y = F from rest, underdamped.
TEST(AdmittanceFilterTest, AcrossThePathIsAMassWithDampingAndSpring) {
  AdmittanceGains params = Unlimited();
  params.mass = {3, 8};
  params.damping = {7, 40};
  const double mass = params.mass[1];
  Filter filter(params);
  filter.Run(2);
  // The leash at the angle a behind the robot to the right: |f_d h - f| is the diagonal of a rhombus.
  const double a = 0.6, tension = 30;
  filter.Force({-tension * std::cos(a), -tension * std::sin(a), 0});
  const Vec<2> e(std::cos(a / 2), std::sin(a / 2));
  const double T = tension * std::cos(a / 2), force = (30 - T) * e[1];
  const double decay = params.damping[1] / (2 * mass);
  const double w = std::sqrt(params.stiffness / mass - decay * decay);
  for (int n = 1; n <= 300; ++n) {
    const AdmittanceMotion& motion = filter.Tick();
    const double t = 0.01 * n;
    const double y = force / params.stiffness *
                     (1 - std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t)));
    const double v = force / (mass * w) * std::exp(-decay * t) * std::sin(w * t);
    EXPECT_THAT(motion.direction, IsNear(e, 1e-12));
    EXPECT_NEAR(motion.tension, T, 1e-12);
    EXPECT_NEAR(motion.offset, y, 1e-12) << n;
    EXPECT_NEAR(filter.walk().left, v, 1e-12) << n;
  }
}

TEST(AdmittanceFilterTest, TurnsWithTheRobotAndLooksOverGroundOnly) {
  Filter straight, turned;
  straight.Force({-45, 5, 0});
  turned.Force({-45, 5, -60}, 2.5);
  for (int n = 0; n < 100; ++n) {
    const AdmittanceMotion a = straight.Tick(), b = turned.Tick();
    EXPECT_THAT(b.velocity, IsNear(a.velocity, 1e-12));
    EXPECT_NEAR(b.tension, a.tension, 1e-11);
  }
  EXPECT_LT(straight.walk().forward, kForward);
}

TEST(AdmittanceFilterTest, KeepsTheLimits) {
  const AdmittanceGains params;
  Filter filter;
  double last = 0, last_left = 0;
  const auto check = [&](int ticks) {
    for (int n = 0; n < ticks; ++n) {
      const AdmittanceMotion& motion = filter.Tick();
      EXPECT_LE(std::abs(motion.velocity[0] - last), params.acceleration * 0.01 + 1e-12);
      EXPECT_LE(std::abs(motion.velocity[1] - last_left), params.acceleration * 0.01 + 1e-12);
      EXPECT_LE(motion.velocity[0], params.max_forward);
      EXPECT_LE(std::abs(motion.velocity[1]), params.max_left);
      last = motion.velocity[0], last_left = motion.velocity[1];
    }
  };
  check(500);
  EXPECT_NEAR(last, kForward, 1e-9);
  filter.Force({-200, 0, 0});  // the person stands still
  check(1000);
  EXPECT_EQ(last, params.min_forward);
  filter.Force({0, 0, 0});  // the leash is slack
  check(1000);
  EXPECT_EQ(last, params.max_forward);
  filter.Force({-10, -300, 0});
  check(20);
  EXPECT_EQ(last_left, -params.max_left);
}

TEST(AdmittanceFilterTest, CommandsOutsideTheLimitsPass) {
  Filter filter;
  filter.Command({.gait = Gait::kTrot, .forward = 0, .left = 0.1, .yaw_rate = 0.3});
  filter.Run(1000);
  EXPECT_NEAR(filter.walk().forward, 0, 1e-9);
  EXPECT_NEAR(filter.walk().left, 0.1, 1e-9);
  filter.Command({.gait = Gait::kTrot, .forward = 0.4});
  filter.Run(1000);
  EXPECT_NEAR(filter.walk().forward, 0.4, 1e-9);
}

TEST(AdmittanceFilterTest, DoesNotWindUp) {
  Filter shortly, for_long;
  shortly.Force({-200, 20, 0});
  for_long.Force({-200, 20, 0});
  shortly.Run(1000);
  for_long.Run(30000);
  shortly.Force({-30, 0, 0});
  for_long.Force({-30, 0, 0});
  for (int n = 0; n < 100; ++n)
    EXPECT_THAT(shortly.Tick().velocity, IsNear(for_long.Tick().velocity, 1e-9)) << n;
}

// A person slower than the command is led at the tension f_d + D (commanded speed - speed of the person).
TEST(AdmittanceFilterTest, HoldsTheTensionOfASlowPerson) {
  Filter filter;
  double tension = 0;
  const double person = 0.05, leash = 120;
  for (int n = 0; n < 3000; ++n) {
    filter.Force({-tension, 0, 0});
    filter.Tick();
    tension = std::max(0.0, tension + leash * 0.01 * (filter.walk().forward - person));
  }
  EXPECT_NEAR(tension, 30 + 40 * (kForward - person), 1e-5);
}

TEST(AdmittanceFilterTest, LooksAheadWhenTheLeashIsSlack) {
  Filter filter;
  for (const Vec<3>& noise : {Vec<3>(0, 0, 0), Vec<3>(2, 1, 0), Vec<3>(-1, -2, 0), Vec<3>(1, 2, 0)}) {
    filter.Force(noise);
    EXPECT_GT(filter.Tick().direction[0], 0.99);
  }
}

TEST(AdmittanceFilterTest, GoesTowardsAPullFromAhead) {
  for (const double pull : {10.0, 29.9, 30.0, 30.1, 45.0, 70.0}) {
    Filter filter;
    filter.Run(1000);
    filter.Force({pull, 0, 0});
    EXPECT_GE(filter.Run(100).velocity[0], kForward - 1e-9) << pull;
  }
}

TEST(AdmittanceFilterTest, StandsAtOnceAndStartsFromRest) {
  Filter filter;
  filter.Force({-35, 4, 0});
  filter.Run(100);
  filter.Command({});
  EXPECT_EQ(filter.Tick().velocity, Vec<2>(0, 0));
  EXPECT_EQ(filter.walk().gait, Gait::kStand);
  EXPECT_EQ(filter.walk().forward, 0);
  EXPECT_GT(filter.Tick().tension, 34) << "is still estimated";
  filter.Command(kTrot);
  Filter fresh;
  fresh.Force({-35, 4, 0});
  for (int n = 0; n < 50; ++n) {
    const AdmittanceMotion again = filter.Tick(), first = fresh.Tick();
    EXPECT_EQ(again.velocity, first.velocity) << n;
    EXPECT_EQ(again.offset, first.offset) << n;
  }
}

// In the steady state of M v' + D v = f_d - T the velocity grows by r (f_d - T) / D.
TEST(AdmittanceFilterTest, AdaptsToThePersonsSpeed) {
  AdmittanceGains gains = Unlimited();
  gains.adaptation_rate = 0.25;
  Filter filter(gains);
  filter.Run(2);
  filter.Force({-32, 0, 0});
  const double at_2s = filter.Run(200).velocity[0], at_3s = filter.Run(100).velocity[0];
  EXPECT_NEAR(at_3s - at_2s, -0.25 * 2 / gains.damping[0], 1e-5);
  filter.Force({-30, 0, 0});
  filter.Run(300);
  const double kept = filter.walk().forward;
  EXPECT_NEAR(kept, kForward - 0.25 * 3 * 2 / gains.damping[0], 2e-3);
  filter.Command({});
  filter.Tick();
  filter.Command(kTrot);
  EXPECT_NEAR(filter.Run(300).velocity[0], kForward, 1e-9) << "after a stop it begins anew";
}

TEST(AdmittanceFilterTest, DoesNotAdaptAtTheLimits) {
  const AdmittanceGains gains{.adaptation_rate = 2};
  Filter filter(gains);
  filter.Force({-0.0, 0, 0});
  filter.Run(1000);
  EXPECT_EQ(filter.walk().forward, gains.max_forward);
  filter.Force({-30, 0, 0});
  EXPECT_NEAR(filter.Run(200).velocity[0], kForward, 0.05);
}

TEST(AdmittanceFilterTest, KeepsTheLimitsWhateverItHasAdapted) {
  const AdmittanceGains gains{.adaptation_rate = 1};
  Filter filter(gains);
  filter.Force({-29, 0, 0});
  filter.Run(300);
  filter.Command({.gait = Gait::kTrot, .forward = 0.19});
  filter.Run(100);
  EXPECT_EQ(filter.walk().forward, gains.max_forward);
  filter.Force({-60, 0, 0});
  filter.Run(500);
  EXPECT_EQ(filter.walk().forward, gains.min_forward);
}

TEST(AdmittanceFilterTest, ForgetsWhatItHasAdaptedWhenItYields) {
  AdmittanceGains gains = Unlimited();
  gains.adaptation_rate = 0.5;
  gains.yield_tension = 45;
  Filter filter(gains);
  filter.Force({-29, 0, 0});
  filter.Run(300);
  filter.Command({});
  filter.Force({-60, 0, 0});
  filter.Run(50);
  EXPECT_EQ(filter.walk().gait, Gait::kTrot);
  filter.Command(kTrot);
  filter.Force({-30, 0, 0});
  EXPECT_NEAR(filter.Run(300).velocity[0], kForward, 1e-6);
}

TEST(AdmittanceFilterTest, YieldsToAPullThatWouldTipAStandingRobot) {
  const AdmittanceGains gains{.yield_tension = 45};
  Filter filter(gains);
  filter.Run(100);
  filter.Command({});
  filter.Force({-44, 0, 0});
  filter.Tick();
  EXPECT_EQ(filter.walk().gait, Gait::kStand);
  filter.Force({-60, 0, 0});
  filter.Run(200);
  EXPECT_EQ(filter.walk().gait, Gait::kTrot) << "the last gait";
  EXPECT_EQ(filter.walk().forward, -gains.max_backward);
  filter.Force({-38, 0, 0});
  filter.Tick();
  EXPECT_EQ(filter.walk().gait, Gait::kTrot);
  filter.Force({-37, 0, 0});
  filter.Tick();
  EXPECT_EQ(filter.walk().gait, Gait::kStand);
  EXPECT_EQ(filter.walk().forward, 0);
  filter.Force({0, 60, 0});
  filter.Run(100);
  EXPECT_EQ(filter.walk().gait, Gait::kTrot);
  EXPECT_GT(filter.walk().left, 0) << "towards the pull";
  filter.Force({60, 0, 0});
  filter.Run(100);
  EXPECT_EQ(filter.walk().gait, Gait::kTrot);
  EXPECT_EQ(filter.walk().forward, 0) << "not forwards";
}

TEST(AdmittanceFilterTest, YieldsToAPullThatLastsNotToNoise) {
  Filter filter({.yield_tension = 45, .yield_time = 0.1});
  const auto keeps = [&](Gait gait, double other_pull) {
    for (int n = 0; n < 200; ++n) {
      filter.Force({n % 3 ? -40.0 : -other_pull, 0, 0});
      filter.Tick();
      ASSERT_EQ(filter.walk().gait, gait) << n;
    }
  };
  filter.Run(100);
  filter.Command({});
  keeps(Gait::kStand, 60);
  filter.Force({-60, 0, 0});
  filter.Run(9);
  EXPECT_EQ(filter.walk().gait, Gait::kStand);
  filter.Tick();
  EXPECT_EQ(filter.walk().gait, Gait::kTrot) << "after 0.1 s";
  keeps(Gait::kTrot, 30);
  filter.Force({-60, 0, 0});
  filter.Run(1000);
  filter.Force({-30, 0, 0});
  filter.Run(12);
  EXPECT_EQ(filter.walk().gait, Gait::kStand) << "after 0.1 s, however long the pull was";
  filter.Command(kTrot);
  filter.Force({-60, 0, 0});
  filter.Run(20);
  filter.Command({});
  filter.Tick();
  EXPECT_EQ(filter.walk().gait, Gait::kTrot) << "the pull lasts since before the stop";
}

TEST(AdmittanceFilterTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<AdmittanceFilter>({{.max_forward = 0.01}}, "max_forward", "min_forward"));
  EXPECT_TRUE(Refuses<AdmittanceFilter>({{.yield_tension = 29}}, "yield_tension", "desired_tension"));
}

class ReferenceAdmittanceTest : public ::testing::Test {
 protected:
  void Pull(double tension) {
    rig_.Fix(block_.body, body_).Fix(block_.wrench, WrenchEstimate{.force_W = tension * -forward_});
  }
  static ReferenceAdmittanceGains Gains() {
    ReferenceAdmittanceGains gains;
    gains.damping[0] = 2 * std::sqrt(gains.mass[0] * gains.stiffness[0]);  // critical
    return gains;
  }
  const double yaw_ = 0.7;
  const Vec<3> forward_{std::cos(yaw_), std::sin(yaw_), 0};
  BodyReference body_{.com_W = {1, 2, 0.5}, .q_WB = QuaternionFromEuler({0, 0, yaw_})};
  TestRig<ReferenceAdmittance> rig_{Gains()};
  const ReferenceAdmittance& block_ = rig_.system();
};

TEST_F(ReferenceAdmittanceTest, TheDesiredForceChangesNothing) {
  Pull(30);
  EXPECT_THAT(rig_.RunTo(1)[block_.modified].com_W, IsNear(body_.com_W, 1e-12));
}

// The critically damped response to a step of 20 N: x = F / K (1 - (1 + w t) e^(-w t)).
TEST_F(ReferenceAdmittanceTest, LagsBehindWhileTheLeashPullsMore) {
  Pull(50);
  const double w = std::sqrt(1000.0 / 8);
  for (double t : {0.05, 0.2, 3.0}) {
    const BodyReference now = rig_.RunTo(t)[block_.modified];
    const double e = std::exp(-w * t), x = -0.02 * (1 - (1 + w * t) * e);
    EXPECT_THAT(now.com_W, IsNear(Vec<3>(body_.com_W + x * forward_), 1e-5)) << t;
    EXPECT_THAT(now.com_velocity_W, IsNear(Vec<3>(-0.02 * w * w * t * e * forward_), 1e-4)) << t;
    EXPECT_THAT(now.com_acceleration_W, IsNear(Vec<3>(-0.02 * w * w * (1 - w * t) * e * forward_), 1e-3))
        << t;
  }
}

// Matrices of the thesis: an axis of its own for each entry.
TEST_F(ReferenceAdmittanceTest, AxesHaveGainsOfTheirOwn) {
  ReferenceAdmittanceGains gains = Gains();
  gains.stiffness << 500, 2000, 4000;
  rig_.Set(block_.gains, gains);
  const Vec<3> left(-forward_[1], forward_[0], 0);
  rig_.Fix(block_.body, body_)
      .Fix(block_.wrench, WrenchEstimate{.force_W = -30 * forward_ + 10 * left + Vec<3>(0, 0, 8)});
  EXPECT_THAT(rig_.RunTo(5)[block_.x], IsNear((Vec<6>() << 0, 0.005, 0.002, 0, 0, 0).finished(), 1e-6));
  EXPECT_TRUE(Refuses<ReferenceAdmittance>(
      [] {
        ReferenceAdmittanceGains wrong;
        wrong.mass[1] = 0;
        return wrong;
      }(),
      "mass"));
}

}  // namespace tenon::admittance_test
