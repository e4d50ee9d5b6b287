#include <tenon/controllers/legged/comparison/nonlinear_disturbance_observer.h>
#include <tenon/tests/controllers/legged/quadruped_bench.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::nonlinear_disturbance_observer_test {

using test::DogBot, test::QuadrupedBench;
using Observed = test::Observed<NonlinearDisturbanceObserver>;

NonlinearDisturbanceObserverParams Params(NdoReading reading) {
  return {.robot = DogBot(), .reading = reading};
}

/// Legs that move in flight, from a start in motion.
QuadrupedBench Flying() {
  QuadrupedBench bench(DogBot());
  bench.x.w_W = {0.5, -0.3, 0.2};
  for (int j = 0; j < kNumJoints; ++j) bench.x.qd[j] = std::cos(j);
  bench.joint_reference = test::Swinging(bench.robot);
  return bench;
}

// The error equation F_hat' = Lambda (F - F_hat), integrated here with the M_q of the moving robot: by the
// implicit Euler rule in both readings, and exactly where M_q / x is long compared with a tick.
TEST(NonlinearDisturbanceObserverTest, ErrorDecaysWithLambda) {
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  RandomStream random(7);
  const Vec<12> torque = test::RandomVector<12>(random, 5);
  for (const NdoReading reading : {NdoReading::kM, NdoReading::kInverse}) {
    QuadrupedBench bench = Flying();
    bench.external = [=](const LeggedState&, const QuadrupedDynamics&, double) {
      Vec<18> force = Vec<18>::Zero();
      force.tail<12>() = torque;
      return force;
    };
    const double x = reading == NdoReading::kM ? 10 : 0.1, h = 1e-3;
    Observed run(bench, Params(reading));
    Vec<12> implicit = torque, exact = torque;  // the errors
    double worst_implicit = 0, worst_exact = 0;
    for (int n = 1; n <= 300; ++n) {
      const Vec<12> error = torque - run.Tick().joint_torque;
      QuadrupedDynamics dynamics;
      DecoupledDynamics decoupled;
      run.bench.model.Calc(run.bench.x, &dynamics);
      run.bench.model.CalcDecoupled(run.bench.x, dynamics, &decoupled);
      const Matrix12 Lambda = x * test::Inverse(decoupled.M_q);
      implicit = test::Solve(Matrix12::Identity() + h * Lambda, implicit);
      const test::SymmetricModes modes(decoupled.M_q);
      const Vec<12> decay = (-x * h * modes.eigenvalues.cwiseInverse()).array().exp();
      exact = (modes.eigenvectors * decay.asDiagonal() * modes.eigenvectors.transpose() * exact).eval();
      worst_implicit = std::max(worst_implicit, (error - implicit).norm());
      worst_exact = std::max(worst_exact, (error - exact).norm());
    }
    EXPECT_LT(worst_implicit, 0.01 * torque.norm());
    if (reading == NdoReading::kInverse) {
      EXPECT_LT(worst_exact, 0.02 * torque.norm());
      EXPECT_GT(exact.norm(), 0.05 * torque.norm()) << "it has not settled yet";
    } else {
      EXPECT_LT(implicit.norm(), 1e-3 * torque.norm()) << "it has settled";
    }
  }
}

TEST(NonlinearDisturbanceObserverTest, StartsOnAMovingRobotWithoutTransient) {
  Observed run(Flying(), Params(NdoReading::kM));
  // An observer with p(0) = 0 would start at X qd, 24 N m.
  for (int n = 0; n < 100; ++n) ASSERT_LT(run.Tick().joint_torque.norm(), 0.1) << n;
}

TEST(NonlinearDisturbanceObserverTest, EstimatesTheForceOnAFoot) {
  const Vec<3> force(15, -10, 5);
  QuadrupedBench bench = Flying();
  bench.external = [=](const LeggedState&, const QuadrupedDynamics& dynamics, double) -> Vec<18> {
    return QuadrupedBench::PointJacobian(dynamics, 2, dynamics.feet[2].p_W).transpose() * force;
  };
  Observed run(bench, Params(NdoReading::kM));
  for (int n = 0; n < 200; ++n) run.Tick();
  const LegForceEstimate& estimate = run.Tick();
  EXPECT_THAT(estimate.foot_force.rear_left, IsNear(force, 0.3));
  EXPECT_LT(estimate.foot_force.front_right.norm(), 0.3);
}

// In the reading with X^-1 a leg with a large X has a slow estimate.
TEST(NonlinearDisturbanceObserverTest, EveryJointHasAGainOfItsOwn) {
  NonlinearDisturbanceObserverParams params = Params(NdoReading::kInverse);
  params.gain = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1e4, 1e4, 1e4};
  QuadrupedBench bench = Flying();
  bench.external = [](const LeggedState&, const QuadrupedDynamics&, double) -> Vec<18> {
    Vec<18> torque = Vec<18>::Zero();
    torque.tail<12>().setConstant(2);
    return torque;
  };
  Observed run(bench, params);
  const Vec<12> estimate = run.RunTo(0.3).joint_torque;
  EXPECT_GT(estimate.head<9>().minCoeff(), 1.5);
  EXPECT_LT(estimate.tail<3>().cwiseAbs().maxCoeff(), 0.1);
}

TEST(NonlinearDisturbanceObserverTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<NonlinearDisturbanceObserver>({}, "robot"));
  NonlinearDisturbanceObserverParams params = Params(NdoReading::kM);
  params.gain = {10, 10};
  EXPECT_TRUE(Refuses<NonlinearDisturbanceObserver>(params, "gain"));
}

}  // namespace tenon::nonlinear_disturbance_observer_test
