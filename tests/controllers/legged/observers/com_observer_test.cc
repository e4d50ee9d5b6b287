#include <tenon/controllers/legged/observers/com_observer.h>
#include <tenon/tests/controllers/legged/quadruped_bench.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::com_observer_test {

using test::A1, test::DogBot, test::QuadrupedBench;
using Observed = test::Observed<ComObserver>;

ComObserverParams Params(const QuadrupedDescription& robot, ForceSource source = ForceSource::kImu) {
  return {.robot = robot, .gains = {.force_source = source}};
}

/// A force on the trunk at p_B and a torque.
QuadrupedBench::External OnTrunk(const Vec<3>& p_B, const Vec<3>& force, const Vec<3>& torque) {
  return [=](const LeggedState& state, const QuadrupedDynamics&, double) {
    Vec<18> out = Vec<18>::Zero();
    const Vec<3> arm = state.R_WB() * p_B;
    out.head<6>() << force, arm.cross(force) + torque;
    return out;
  };
}

QuadrupedBench Standing(const QuadrupedDescription& robot) {
  QuadrupedBench bench(robot);
  bench.StandHere();
  bench.joint_reference = [stance = robot.stance](double t) {  // and squats, one side more than the other
    Vec<12> q = stance;
    for (int leg = 0; leg < kNumLegs; ++leg)
      q.segment<2>(3 * leg + 1) += (0.1 + 0.02 * leg) * (1 - std::cos(8 * t)) * Vec<2>(0.5, -1);
    return q;
  };
  return bench;
}

// A constant force gives the step response of the filter from the first tick on, while robot and legs move.
TEST(ComObserverTest, StepGivesTheFirstOrderResponse) {
  const Vec<3> force(30, -20, -60), torque(3, -2, 4);
  for (const ForceSource source : {ForceSource::kImu, ForceSource::kMomentum}) {
    ComObserverParams params = Params(DogBot(), source);
    params.gains.force_bandwidth = {20, 40, 10};
    params.gains.torque_bandwidth = 30;
    QuadrupedBench bench = Standing(params.robot);
    bench.external = [=](const LeggedState& state, const QuadrupedDynamics& dynamics, double) {
      Vec<18> out = Vec<18>::Zero();  // through the centre of mass
      out.head<6>() << force, (dynamics.com_W - state.p_WB).cross(force) + torque;
      return out;
    };
    Observed run(bench, params);
    for (int n = 1; n <= 300; ++n) {
      const WrenchEstimate& estimate = run.Tick();
      const Vec<3> response(-std::expm1(-20e-3 * n), -std::expm1(-40e-3 * n), -std::expm1(-10e-3 * n));
      ASSERT_THAT(estimate.force_W,
                  IsNear(Vec<3>(force.cwiseProduct(response)), source == ForceSource::kImu ? 0.35 : 0.1))
          << n;
      ASSERT_THAT(estimate.torque_W, IsNear(torque * -std::expm1(-30e-3 * n), 0.02)) << n;
    }
  }
}

TEST(ComObserverTest, AKnownWrenchIsNotADisturbance) {
  const Vec<3> known(80, 10, 60), unknown(0, 25, 0);
  for (const ForceSource source : {ForceSource::kImu, ForceSource::kMomentum}) {
    QuadrupedBench bench = Standing(DogBot());
    bench.external = [=](const LeggedState& state, const QuadrupedDynamics& dynamics, double) {
      Vec<18> out = Vec<18>::Zero();  // through the centre of mass
      out.head<6>() << known + unknown, (dynamics.com_W - state.p_WB).cross(known + unknown);
      return out;
    };
    Observed run(bench, Params(DogBot(), source));
    run.rig.Fix(run.rig->known_wrench, WrenchEstimate{known, Vec<3>::Zero()});
    EXPECT_THAT(run.RunTo(0.6).force_W, IsNear(unknown, 0.4));
    EXPECT_THAT(run.estimate().torque_W, IsNear(Vec<3>(Vec<3>::Zero()), 0.02));
  }
}

TEST(ComObserverTest, WrenchOfAForceOffTheCentreOfMass) {
  const Vec<3> p_B(0.2, -0.1, 0.05), force(10, 25, -15);
  QuadrupedBench bench(A1());
  bench.StandHere();
  bench.external = OnTrunk(p_B, force, Vec<3>::Zero());
  Observed run(bench, Params(A1()));
  const WrenchEstimate& estimate = run.RunTo(0.6);
  const QuadrupedDynamics dynamics = test::DynamicsOf(run.bench.model, run.bench.x);
  const Vec<3> arm = run.bench.x.p_WB + run.bench.x.R_WB() * p_B - dynamics.com_W;
  EXPECT_THAT(estimate.force_W, IsNear(force, 0.1));
  EXPECT_THAT(estimate.torque_W, IsNear(arm.cross(force), 0.05));
}

// Only known forces act on a robot that falls, spins and swings its legs: the estimate stays zero, also after
// a start with velocities.
TEST(ComObserverTest, StartsOnAMovingRobotWithoutTransient) {
  for (const ForceSource source : {ForceSource::kImu, ForceSource::kMomentum}) {
    QuadrupedBench bench(DogBot());
    bench.x.v_W = {1, -2, 3};
    bench.x.w_W = {1, 2, -1};
    for (int j = 0; j < kNumJoints; ++j) bench.x.qd[j] = 5 * std::cos(j);
    bench.ground = [](const LeggedState&, const QuadrupedDynamics&, double t) {
      return FootForces{.front_right = {5 * std::sin(20 * t), 3, 40 + 20 * std::cos(15 * t)}};
    };
    Observed run(bench, Params(DogBot(), source));
    for (int n = 0; n < 100; ++n) {
      const WrenchEstimate& estimate = run.Tick();
      ASSERT_LT(estimate.torque_W.norm(), 5e-3) << n;
      ASSERT_LT(estimate.force_W.norm(), source == ForceSource::kImu ? 1.5 : 0.01) << n;
    }
  }
}

// Away from the trunk's origin the IMU also measures 2 m/s^2 of the rotation, equivalent to 45 N.
TEST(ComObserverTest, CarriesTheAccelerationFromTheInertialUnit) {
  for (const Vec<3>& place : {Vec<3>(0, 0, 0), Vec<3>(0.3, -0.1, 0.2)}) {
    QuadrupedDescription robot = DogBot();
    robot.imu_B = place;
    QuadrupedBench bench(robot);
    bench.x.w_W = {1, 2, -1};
    bench.external = OnTrunk({0, 0.1, 0}, {20, 0, 0}, Vec<3>::Zero());
    Observed run(bench, Params(robot));
    for (int n = 1; n <= 200; ++n)
      ASSERT_THAT(run.Tick().force_W, IsNear(Vec<3>(-20, 0, 0) * std::expm1(-20e-3 * n), 1)) << n;
  }
}

// Errors of the estimated velocity of the trunk do not reach the estimated force.
TEST(ComObserverTest, DoesNotReadTheVelocityOfTheTrunk) {
  Observed right(Standing(DogBot()), Params(DogBot())), wrong(Standing(DogBot()), Params(DogBot()));
  for (int n = 0; n < 100; ++n) {
    right.Tick();
    const Vec<3> v = wrong.bench.x.v_W;
    wrong.bench.Step();
    LeggedState seen = wrong.bench.x;
    seen.v_W += Vec<3>(0.1 * std::sin(0.3 * n), 0.2, v[0]);
    wrong.rig.Fix(wrong.rig->state, seen)
        .Fix(wrong.rig->foot_forces, wrong.bench.Feet())
        .Fix(wrong.rig->imu, wrong.bench.Imu())
        .Tick();
  }
  EXPECT_THAT(wrong.estimate().force_W, IsNear(right.estimate().force_W, 1e-9));
  EXPECT_THAT(wrong.estimate().torque_W, IsNear(right.estimate().torque_W, 1e-9));
}

// Focchi et al. 2020: momentum minus what known forces have given, with the gains that they publish,
//
//     f = 25 (m x' - int (sum f_i + m g + f) dt),   tau = 10 (L - int (sum (p_i - x) x f_i + tau) dt),
//
// integrated here by the trapezoidal rule.
TEST(ComObserverTest, IsTheCentroidalMomentumObserverByItsGains) {
  QuadrupedBench bench = Standing(DogBot());
  bench.external = [](const LeggedState&, const QuadrupedDynamics&, double t) {
    Vec<18> out = Vec<18>::Zero();
    out.head<6>() << 30 * std::sin(12 * t), -20, 40 * std::cos(9 * t), 4, 3 * std::sin(15 * t), -2;
    return out;
  };
  ComObserverParams params = Params(DogBot());
  params.gains = CentroidalMomentumObserver();
  Observed run(bench, params);

  const double h = 1e-3;
  Vec<6> gain, momentum, start, rate, given = Vec<6>::Zero(), published = Vec<6>::Zero();
  gain << 25, 25, 25, 10, 10, 10;
  const auto look = [&] {
    const QuadrupedDynamics dynamics = test::DynamicsOf(run.bench.model, run.bench.x);
    const FootForces feet = run.bench.ground(run.bench.x, dynamics, run.bench.t);
    momentum << DogBot().mass() * dynamics.com_velocity_W, dynamics.angular_momentum_W;
    rate << 0, 0, -9.81 * DogBot().mass(), 0, 0, 0;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Vec<3> p = dynamics.feet[leg].p_W - Vec<3>(0, 0, DogBot().foot_radius);
      rate.head<3>() += feet[leg];
      rate.tail<3>() += (p - dynamics.com_W).cross(feet[leg]);
    }
  };
  look();
  start = momentum;
  double largest = 0;
  for (int n = 1; n <= 600; ++n) {
    const WrenchEstimate& estimate = run.Tick();
    const Vec<6> before = rate;
    look();
    given += h / 2 * (before + rate + published);  // and h / 2 of what is published next
    published = (gain.array() * (momentum - start - given).array() / (1 + h / 2 * gain.array())).matrix();
    given += h / 2 * published;
    ASSERT_THAT(estimate.force_W, IsNear(published.head<3>(), 0.02)) << n;
    ASSERT_THAT(estimate.torque_W, IsNear(published.tail<3>(), 0.002)) << n;
    largest = std::max(largest, published.tail<3>().norm());
  }
  EXPECT_GT(largest, 3) << "there was something to estimate";
}

TEST(ComObserverTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<ComObserver>({}, "robot"));
}

// The momenta of the two sources differ by the trunk's velocity, but the force is the same.
TEST(ComObserverTest, AnotherSourceGoesOnFromTheEstimate) {
  const Vec<3> force(30, -20, -60);
  QuadrupedBench bench = Standing(DogBot());
  bench.external = OnTrunk({0, 0, 0}, force, {0, 0, 0});
  Observed run(bench, Params(DogBot()));
  run.RunTo(0.4);
  ASSERT_GT(run.bench.x.v_W.norm(), 0.02);
  for (const ForceSource source : {ForceSource::kMomentum, ForceSource::kImu}) {
    run.rig.Set(run.rig->gains, {.force_source = source});
    for (int n = 0; n < 20; ++n) ASSERT_THAT(run.Tick().force_W, IsNear(force, 0.5)) << n;
  }
}

}  // namespace tenon::com_observer_test
