#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/tests/controllers/legged/quadruped_bench.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::leg_momentum_observer_test {

using test::A1, test::DogBot, test::QuadrupedBench;
using Observed = test::Observed<LegMomentumObserver>;

/// A robot that flies, turns and moves its legs under known forces on its feet.
QuadrupedBench Flying(const QuadrupedDescription& robot) {
  QuadrupedBench bench(robot);
  bench.x.v_W = {0.4, -0.2, 1};
  bench.x.w_W = {0.5, -0.3, 0.2};
  bench.joint_reference = test::Swinging(robot);
  bench.ground = [](const LeggedState&, const QuadrupedDynamics&, double t) {
    return FootForces{.front_left = {5 * std::sin(20 * t), 3, 40 + 20 * std::cos(15 * t)},
                      .rear_right = {0, -8 * std::cos(12 * t), 50}};
  };
  return bench;
}

QuadrupedBench::External AtJoints(const Vec<12>& torque) {
  return [torque](const LeggedState&, const QuadrupedDynamics&, double) {
    Vec<18> force = Vec<18>::Zero();
    force.tail<12>() = torque;
    return force;
  };
}

LegMomentumObserverParams Params(const QuadrupedDescription& robot, std::vector<double> gains = {100}) {
  return {.robot = robot, .gains = {.gains = std::move(gains)}};
}

/// The step response of a Butterworth filter, by partial fractions.
double StepResponse(int order, double bandwidth, double t) {
  using Complex = std::complex<double>;
  std::vector<Complex> poles;
  for (int k = 0; k < order; ++k)
    poles.push_back(std::polar(bandwidth, std::numbers::pi * (2 * k + order + 1) / (2 * order)));
  Complex y = 1;
  for (int k = 0; k < order; ++k) {
    Complex residue = std::pow(bandwidth, order) / poles[k];
    for (int j = 0; j < order; ++j)
      if (j != k) residue /= poles[k] - poles[j];
    y += residue * std::exp(poles[k] * t);
  }
  return y.real();
}

TEST(LegMomentumObserverTest, StepGivesTheTransferFunctionOfEveryOrder) {
  RandomStream random(3);
  const Vec<12> step = test::RandomVector<12>(random, 5);
  for (const LegDynamics form : {LegDynamics::kExact, LegDynamics::kThesis}) {
    for (int order = 1; order <= 5; ++order) {
      LegMomentumObserverParams params = Params(DogBot(), ButterworthGains(order, 50));
      params.gains.dynamics = form;
      QuadrupedBench bench = Flying(params.robot);
      bench.external = AtJoints(step);
      Observed run(bench, params);
      double worst = 0;
      for (int n = 1; n <= 200; ++n) {
        const Vec<12> estimate = run.Tick().joint_torque;
        worst = std::max(worst, (estimate / StepResponse(order, 50, 1e-3 * n) - step).norm() *
                                    StepResponse(order, 50, 1e-3 * n) / step.norm());
      }
      EXPECT_LT(worst, 1e-3) << "order " << order << ", " << static_cast<int>(form);
    }
  }
}

TEST(LegMomentumObserverTest, ForceOnTheTrunkDoesNotReachTheLegs) {
  for (const LegDynamics form : {LegDynamics::kExact, LegDynamics::kThesis}) {
    LegMomentumObserverParams params = Params(DogBot());
    params.gains.dynamics = form;
    QuadrupedBench bench(params.robot);
    bench.StandHere();
    bench.external = [](const LeggedState&, const QuadrupedDynamics&, double) {
      Vec<18> force = Vec<18>::Zero();
      force.head<6>() << 60, 50, -40, 5, 5, 5;
      return force;
    };
    Observed run(bench, params);
    double torque = 0, force = 0;
    for (int n = 0; n < 300; ++n) {
      const LegForceEstimate& estimate = run.Tick();
      torque = std::max(torque, estimate.joint_torque.cwiseAbs().maxCoeff());
      for (int leg = 0; leg < kNumLegs; ++leg) force = std::max(force, estimate.foot_force[leg].norm());
    }
    const double push = Vec<3>(60, 50, -40).norm();
    if (form == LegDynamics::kExact) {
      EXPECT_LT(force, 0.01 * push);
      EXPECT_LT(torque, 0.01 * push * 0.3);  // at the length of a leg
    } else {
      EXPECT_GT(force, 0.1 * push) << "what the thesis neglects";
    }
  }
}

TEST(LegMomentumObserverTest, ForceOnALegAppearsThereOnly) {
  const QuadrupedDescription robot = DogBot();
  const Vec<3> force(20, -12, 8);
  for (int pushed = 0; pushed < kNumLegs; ++pushed) {
    QuadrupedBench bench = Flying(robot);
    bench.external = [=](const LeggedState&, const QuadrupedDynamics& dynamics, double) -> Vec<18> {
      const Vec<3> centre = dynamics.feet[pushed].p_W;
      return QuadrupedBench::PointJacobian(dynamics, pushed, centre).transpose() * force;
    };
    Observed run(bench, Params(robot));
    const LegForceEstimate& estimate = run.RunTo(0.15);
    for (int leg = 0; leg < kNumLegs; ++leg) {
      EXPECT_THAT(estimate.foot_force[leg],
                  IsNear(leg == pushed ? force : Vec<3>(Vec<3>::Zero()), (leg == pushed ? 0.05 : 1e-3) * 25))
          << "leg " << leg << " of a push on " << pushed;
    }
  }
}

TEST(LegMomentumObserverTest, StartsOnAMovingRobotWithoutTransient) {
  for (const LegDynamics form : {LegDynamics::kExact, LegDynamics::kThesis}) {
    LegMomentumObserverParams params = Params(DogBot(), ButterworthGains(3, 100));
    params.gains.dynamics = form;
    QuadrupedBench bench = Flying(params.robot);
    for (int j = 0; j < kNumJoints; ++j) bench.x.qd[j] = 5 * std::cos(j);
    Observed run(bench, params);
    for (int n = 0; n < 50; ++n) ASSERT_LT(run.Tick().joint_torque.norm(), 5e-3) << n;
  }
}

// A straight leg carries a force along itself without torques, so this part of the force is not observable.
TEST(LegMomentumObserverTest, FootForceStaysSmallNearASingularLeg) {
  const QuadrupedDescription robot = DogBot();
  LeggedState x{.q = robot.stance};
  QuadrupedDynamics dynamics;
  const QuadrupedModel model(robot);
  double straight = x.q[2];  // where the Jacobian of the front left leg is singular
  double smallest = 1;
  for (double knee = -2; knee < 2; knee += 1e-3) {
    x.q[2] = knee;
    model.Calc(x, &dynamics);
    if (const double det = std::abs(dynamics.feet[0].J_leg.determinant()); det < smallest)
      smallest = det, straight = knee;
  }
  ASSERT_LT(smallest, 1e-4);

  LegMomentumObserverParams params = Params(robot, {1000});
  const auto estimate = [&](double knee) {
    LeggedState posture{.q = robot.stance};
    posture.q[2] = knee;
    TestRig<LegMomentumObserver> rig(params);
    rig.Fix(rig->state, posture).Fix(rig->torque, Vec<12>::Constant(-3)).Fix(rig->foot_forces, FootForces());
    for (int n = 0; n < 30; ++n) rig.Tick();
    return rig[rig->estimate];
  };
  Vec<3> last = estimate(straight - 0.15).foot_force.front_left;
  for (double knee = straight - 0.15; knee < straight + 0.15; knee += 2e-3) {
    const LegForceEstimate at = estimate(knee);
    const Vec<3> force = at.foot_force.front_left;
    EXPECT_LT(force.norm(), at.joint_torque.head<3>().norm() / params.gains.min_singular_value);
    EXPECT_LT((force - last).norm(),
              0.35 * at.joint_torque.head<3>().norm() / params.gains.min_singular_value);
    last = force;
  }
  // A regular leg has the exact solution.
  model.Calc(LeggedState{.q = robot.stance}, &dynamics);
  const LegForceEstimate regular = estimate(robot.stance[2]);
  EXPECT_THAT(dynamics.feet[0].J_leg.transpose() * regular.foot_force.front_left,
              IsNear(regular.joint_torque.head<3>(), 1e-9));
}

TEST(LegMomentumObserverTest, TakesGainsADesignOrItsDefault) {
  LegObserverGains gains;
  EXPECT_EQ(gains.Gains(), (std::vector<double>{100, 256}));
  gains.butterworth = ButterworthDesign{3, 40};
  EXPECT_EQ(gains.Gains(), ButterworthGains(3, 40));
  gains.butterworth.reset();
  gains.gains = {7};
  EXPECT_EQ(gains.Gains(), std::vector<double>{7});
}

TEST(LegMomentumObserverTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<LegMomentumObserver>({}, "robot"));
  LegMomentumObserverParams params = Params(DogBot());
  params.gains.butterworth = ButterworthDesign{3, 100};
  EXPECT_TRUE(Refuses<LegMomentumObserver>(params, "gains_per_s", "butterworth"));
  params = Params(DogBot(), {});
  params.gains.butterworth = ButterworthDesign{0, 100};
  EXPECT_TRUE(Refuses<LegMomentumObserver>(params, "order", "0"));
  // The order in which the thesis prints its gains.
  params = Params(DogBot(), {17.5, 6.28, 2.25});
  EXPECT_TRUE(Refuses<LegMomentumObserver>(params, "17.5, 6.28, 2.25", "-6.23, -5.63 ± 2.82i"));
}

// A constant disturbance stays estimated when order and dynamics change.
TEST(LegMomentumObserverTest, OtherGainsGoOnFromTheEstimate) {
  const Vec<12> torque = Vec<12>::Constant(2);
  QuadrupedBench bench = Flying(DogBot());
  bench.external = AtJoints(torque);
  Observed run(bench, Params(DogBot()));
  run.RunTo(0.2);
  for (const int order : {3, 1, 5}) {
    run.rig.Set(run.rig->gains, {.butterworth = ButterworthDesign{order, 80},
                                 .dynamics = order == 1 ? LegDynamics::kThesis : LegDynamics::kExact});
    for (int n = 0; n < 50; ++n) ASSERT_THAT(run.Tick().joint_torque, IsNear(torque, 0.02)) << order;
  }
}

Eigen::VectorXd AsVector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

TEST(EstimatorGainsTest, ButterworthByPolynomial) {
  const double w = 40;
  EXPECT_THAT(AsVector(ButterworthGains(1, w)), IsNear(AsVector({w}), 1e-12));
  EXPECT_THAT(AsVector(ButterworthGains(3, w)), IsNear(AsVector({w / 2, w, 2 * w}), 1e-12));
  // (s^2 + w s + w^2) (s + w), and for order 2 s^2 + sqrt(2) w s + w^2.
  EXPECT_THAT(AsVector(GainsOfPolynomial({w * w * w, 2 * w * w, 2 * w})),
              IsNear(AsVector(ButterworthGains(3, w)), 1e-12));
  EXPECT_THAT(AsVector(GainsOfPolynomial({w * w, std::sqrt(2) * w})),
              IsNear(AsVector(ButterworthGains(2, w)), 1e-12));
}

TEST(EstimatorGainsTest, ButterworthPolesLieOnACircle) {
  for (int order = 1; order <= kMaxEstimatorOrder; ++order) {
    std::vector<double> angles;
    for (const auto& pole : EstimatorPoles(ButterworthGains(order, 7))) {
      EXPECT_NEAR(std::abs(pole), 7, 1e-6) << order;
      angles.push_back(std::arg(-pole));
    }
    std::sort(angles.begin(), angles.end());
    for (int k = 0; k < order; ++k)
      EXPECT_NEAR(angles[k], std::numbers::pi * (2 * k + 1 - order) / (2 * order), 1e-6);
  }
}

// The characteristic polynomial of three gains.
TEST(EstimatorGainsTest, PolesAreTheRootsOfThePolynomial) {
  const std::vector<double> gains{2.25, 6.28, 17.5};
  for (const auto& s : EstimatorPoles(gains)) {
    const auto p = s * s * s + gains[2] * s * s + gains[1] * gains[2] * s + gains[0] * gains[1] * gains[2];
    EXPECT_LT(std::abs(p), 1e-9);
    EXPECT_LT(s.real(), 0);
  }
}

TEST(EstimatorGainsTest, NoiseBandwidthInClosedForm) {
  const double w = 30;
  for (int order = 1; order <= 6; ++order)
    EXPECT_NEAR(NoiseBandwidth(ButterworthGains(order, w)),
                w / (4 * order * std::sin(std::numbers::pi / (2 * order))), 1e-9);
  // c_1 c_2 K_1 / (4 (c_1 c_2 - c_0)) for order 3.
  const double c0 = 2.25 * 6.28 * 17.5, c1 = 6.28 * 17.5, c2 = 17.5;
  EXPECT_NEAR(NoiseBandwidth({2.25, 6.28, 17.5}), 2.25 * c1 * c2 / (4 * (c1 * c2 - c0)), 1e-12);
}

TEST(EstimatorGainsTest, RefusesUnstableGains) {
  // Gains in reverse order, as a reader of the thesis may give them.
  const std::vector<double> reversed{17.5, 6.28, 2.25};
  EXPECT_TRUE(
      Throws<ParameterError>([&] { DemandHurwitz(reversed); }, "17.5, 6.28, 2.25", "2.01 ± 5.95i, -6.28"));
  for (const std::vector<double>& gains :
       {std::vector<double>{-1}, {0}, {}, std::vector<double>(13, 1.0), {1, NAN}})
    EXPECT_TRUE(Throws<ParameterError>([&] { DemandHurwitz(gains); }, "gain"));
  EXPECT_TRUE(Throws<ParameterError>([] { ButterworthGains(0, 1); }, "order", "0"));
  EXPECT_TRUE(Throws<ParameterError>([] { ButterworthGains(2, 0); }, "0 rad/s"));
  EXPECT_TRUE(Throws<ParameterError>([] { GainsOfPolynomial({1, 0}); }));
  EXPECT_TRUE(Throws<ParameterError>([] { NoiseBandwidth({-1}); }));
}

// Amplitude and phase for a sine, given by its mean over each interval; the error of the staircase is of
// order (w h)^2.
TEST(DisturbanceFilterTest, HasTheTransferFunction) {
  const std::vector<double> gains{2.25, 6.28, 17.5};
  const double h = 1e-3, w = 5;
  const DisturbanceFilter filter(gains, h);
  auto memory = filter.Start<2>();
  const std::complex<double> s(0, w);
  const std::complex<double> response =
      gains[0] * gains[1] * gains[2] /
      (s * s * s + gains[2] * s * s + gains[1] * gains[2] * s + gains[0] * gains[1] * gains[2]);
  for (int n = 1; n <= 10000; ++n) {
    const double mean = (std::cos(w * h * (n - 1)) - std::cos(w * h * n)) / (w * h);
    filter.Advance<2>(Vec<2>(mean, 0), &memory);
    if (n < 5000) continue;
    const double expected = (response * std::exp(s * (h * n))).imag();
    ASSERT_NEAR(DisturbanceFilter::Estimate<2>(memory)[0], expected, 1e-5) << n;
  }
}

// Two steps of half the interval equal one step of the interval, because the solution is exact.
TEST(DisturbanceFilterTest, StepsComposeExactly) {
  const std::vector<double> gains = ButterworthGains(4, 300);
  const DisturbanceFilter whole(gains, 4e-3), half(gains, 2e-3);
  auto once = whole.Start<2>(), twice = once;
  for (int n = 0; n < 20; ++n) {
    const Vec<2> f(std::sin(n), n % 3);
    whole.Advance<2>(f, &once);
    half.Advance<2>(f, &twice);
    half.Advance<2>(f, &twice);
    ASSERT_THAT(once, IsNear(twice, 1e-10));
  }
}

}  // namespace tenon::leg_momentum_observer_test
