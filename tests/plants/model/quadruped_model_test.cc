#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

namespace tenon::quadruped_model_test {

using test::RandomState, test::RandomVector, test::Velocities;

/// Constant joint torques and forces on the feet.
struct Loads {
  Vec<12> tau = Vec<12>::Zero();
  FootForces force;
};

Loads RandomLoads(RandomStream& random) {
  Loads loads;
  loads.tau = RandomVector<12>(random, 10);
  for (int leg = 0; leg < kNumLegs; ++leg) loads.force[leg] = RandomVector<3>(random, 50);
  return loads;
}

Vec<18> ForwardDynamics(const QuadrupedDynamics& dynamics, const Loads& loads) {
  Vec<18> force = -dynamics.bias();
  force.tail<12>() += loads.tau;
  for (int leg = 0; leg < kNumLegs; ++leg) force += dynamics.FootJacobian(leg).transpose() * loads.force[leg];
  return test::Solve(dynamics.M, force);
}

/// x after dt with constant rates.
LeggedState Moved(const LeggedState& x, double dt, const LeggedState& rate) {
  LeggedState out = x;
  out.p_WB += dt * rate.p_WB;
  out.q_WB = (x.q_WB + dt * rate.q_WB).normalized();
  out.q += dt * rate.q;
  out.v_W += dt * rate.v_W;
  out.w_W += dt * rate.w_W;
  out.qd += dt * rate.qd;
  return out;
}

LeggedState Rate(const QuadrupedModel& model, const Loads& loads, const LeggedState& x) {
  const QuadrupedDynamics dynamics = test::DynamicsOf(model, x);
  const Vec<18> a = ForwardDynamics(dynamics, loads);
  const Vec<4> half(0, x.w_W[0] / 2, x.w_W[1] / 2, x.w_W[2] / 2);
  return {x.v_W, QuaternionProduct(half, x.q_WB), x.qd, a.head<3>(), a.segment<3>(3), a.tail<12>()};
}

/// d/dt of `of`(state, dynamics) along the motion from x under the loads, by central differences to fourth
/// order.
template <class F>
auto RateAlongMotion(const QuadrupedModel& model, const Loads& loads, const LeggedState& x, const F& of) {
  const double h = 1e-4;
  const LeggedState rate = Rate(model, loads, x);
  const auto at = [&](double t) {
    QuadrupedDynamics dynamics;
    const LeggedState moved = Moved(x, t, rate);
    model.Calc(moved, &dynamics);
    return of(moved, dynamics);
  };
  return ((8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)).eval();
}

struct QuadrupedModelTest : ::testing::TestWithParam<const char*> {
  const QuadrupedDescription robot_ =
      LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/" + GetParam() + ".yaml");
  const QuadrupedModel model_{robot_};
  RandomStream random_{11};
  QuadrupedDynamics dynamics_;
};
INSTANTIATE_TEST_SUITE_P(Robots, QuadrupedModelTest, ::testing::Values("dogbot", "a1"),
                         [](const auto& info) { return std::string(info.param); });

TEST_P(QuadrupedModelTest, MomentaAreProjectionsOfTheMassMatrix) {
  for (int i = 0; i < 20; ++i) {
    const LeggedState x = RandomState(random_);
    model_.Calc(x, &dynamics_);
    const Vec<18> nu = Velocities(x), momentum = dynamics_.M * nu;
    EXPECT_THAT(momentum.head<3>(), IsNear(robot_.mass() * dynamics_.com_velocity_W, 1e-12));
    EXPECT_THAT(dynamics_.angular_map * nu, IsNear(dynamics_.angular_momentum_W, 1e-12));
    EXPECT_THAT(momentum.tail<12>(), IsNear(dynamics_.leg_momentum, 1e-12));
    for (int leg = 0; leg < kNumLegs; ++leg)
      EXPECT_THAT(dynamics_.FootJacobian(leg) * nu, IsNear(dynamics_.feet[leg].v_W, 1e-12));
  }
}

TEST_P(QuadrupedModelTest, FeetAndHipsAgreeWithTheDescription) {
  const LeggedState x = RandomState(random_);
  model_.Calc(x, &dynamics_);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const Eigen::Vector3d p = x.p_WB + x.R_WB() * robot_.FootPosition(leg, x.q);
    EXPECT_THAT(dynamics_.feet[leg].p_W, IsNear(p, 1e-14));
    const Eigen::Vector3d hip = x.p_WB + x.R_WB() * robot_.HipPosition(leg, x.q);
    EXPECT_THAT(dynamics_.origin_W[3 * leg + 1], IsNear(hip, 1e-14));
  }
}

// The material point of the shank that touches a plane at a constant offset from the foot's centre.
TEST_P(QuadrupedModelTest, ThePointInContactIsTheShanks) {
  const Vec<3> arm(0.005, -0.01, -0.02);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    const LeggedState x = RandomState(random_);
    const Loads loads = RandomLoads(random_);
    model_.Calc(x, &dynamics_);
    const Vec<18> a = ForwardDynamics(dynamics_, loads);
    const QuadrupedDynamics::Foot contact = dynamics_.Contact(leg, arm);
    EXPECT_THAT(contact.p_W, IsNear(dynamics_.feet[i].p_W + arm, 1e-15));
    dynamics_.feet[i] = contact;
    EXPECT_THAT(contact.v_W, IsNear(dynamics_.FootJacobian(leg) * Velocities(x), 1e-12));
    EXPECT_THAT(
        dynamics_.FootJacobian(leg) * a + contact.bias,
        IsNear(RateAlongMotion(model_, loads, x,
                               [&](auto&, const auto& d) -> Vec<3> { return d.Contact(leg, arm).v_W; }),
               1e-8 * (1 + a.norm())));
  }
}

TEST_P(QuadrupedModelTest, ForcesChangeTheCentroidalMomentum) {
  // Newton and Euler for the whole robot: only gravity and the feet's forces act from outside.
  for (int i = 0; i < 20; ++i) {
    const Loads loads = RandomLoads(random_);
    model_.Calc(RandomState(random_), &dynamics_);
    const Vec<18> a = ForwardDynamics(dynamics_, loads);
    Eigen::Vector3d force(0, 0, -9.81 * model_.mass()), torque = Eigen::Vector3d::Zero();
    for (int leg = 0; leg < kNumLegs; ++leg) {
      force += loads.force[leg];
      torque += (dynamics_.feet[leg].p_W - dynamics_.com_W).cross(loads.force[leg]);
    }
    EXPECT_THAT(dynamics_.M.topRows<3>() * a + model_.mass() * dynamics_.com_bias_W, IsNear(force, 1e-9));
    EXPECT_THAT(dynamics_.angular_map * a + dynamics_.angular_momentum_bias_W, IsNear(torque, 1e-9));
  }
}

TEST_P(QuadrupedModelTest, LegMomentumObeysItsLaw) {
  for (int i = 0; i < 5; ++i) {
    const LeggedState x = RandomState(random_);
    const Loads loads = RandomLoads(random_);
    model_.Calc(x, &dynamics_);
    Vec<12> rate = dynamics_.leg_momentum_rate + loads.tau - dynamics_.gravity.tail<12>();
    for (int leg = 0; leg < kNumLegs; ++leg)
      rate.segment<3>(3 * leg) += dynamics_.feet[leg].J_leg.transpose() * loads.force[leg];
    EXPECT_THAT(rate,
                IsNear(RateAlongMotion(model_, loads, x, [](auto&, const auto& d) { return d.leg_momentum; }),
                       1e-7 * (1 + rate.norm())));
  }
}

TEST_P(QuadrupedModelTest, TheDecoupledFormIsTheSameDynamics) {
  for (int i = 0; i < 5; ++i) {
    const LeggedState x = RandomState(random_);
    const Loads loads = RandomLoads(random_);
    model_.Calc(x, &dynamics_);
    DecoupledDynamics decoupled;
    model_.CalcDecoupled(x, dynamics_, &decoupled);
    const Vec<12> qdd = ForwardDynamics(dynamics_, loads).tail<12>();
    Vec<12> force = loads.tau;
    for (int leg = 0; leg < kNumLegs; ++leg)
      force += decoupled.J_q.middleRows<3>(3 * leg).transpose() * loads.force[leg];
    EXPECT_THAT(decoupled.M_q * qdd + decoupled.coriolis, IsNear(force, 1e-9));  // gravity is not there
    EXPECT_THAT(decoupled.momentum, IsNear(decoupled.M_q * x.qd, 0));
    const auto momentum = [&](const LeggedState& at, const QuadrupedDynamics& d) {
      DecoupledDynamics moved;
      model_.CalcDecoupled(at, d, &moved);
      return moved.momentum;
    };
    EXPECT_THAT(decoupled.momentum_rate + force,
                IsNear(RateAlongMotion(model_, loads, x, momentum), 1e-7 * (1 + force.norm())));
  }
}

TEST_P(QuadrupedModelTest, LegJacobiansOfOtherPoints) {
  const LeggedState x = RandomState(random_);
  model_.Calc(x, &dynamics_);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto& foot = dynamics_.feet[leg];
    EXPECT_THAT(dynamics_.LegJacobian(leg, foot.p_W), IsNear(foot.J_leg, 0));
    // A point on the knee's axis does not move with the knee.
    EXPECT_THAT(dynamics_.LegJacobian(leg, dynamics_.origin_W[3 * leg + 2]).col(2),
                IsNear(Eigen::Vector3d::Zero(), 0));
  }
}

TEST(StandingTest, IsTheNominalStanceOnLevelGround) {
  const QuadrupedDescription robot = test::DogBot();
  const LeggedState x = StandingOn(robot, {});
  EXPECT_EQ(x.q, robot.stance);
  EXPECT_THAT(x.p_WB, IsNear(test::Standing(robot).p_WB, 1e-12));
  EXPECT_THAT(x.R_WB(), IsNear(Eigen::Matrix3d::Identity(), 1e-15));
}

TEST(StandingTest, FeetTouchASlopeAndTheCoMIsOverThem) {
  for (const QuadrupedDescription& robot : {test::DogBot(), test::A1()}) {
    QuadrupedDynamics level, on_slope;
    QuadrupedModel(robot).Calc(test::Standing(robot), &level);
    const GroundPlane ground{.p_W = {2, -1, 0.3}, .slope = {0.3, -0.2}};
    const LeggedState x = StandingOn(robot, ground, 0.8);
    QuadrupedModel(robot).Calc(x, &on_slope);
    EXPECT_THAT(x.R_WB().col(2), IsNear(ground.Normal(), 1e-12));
    Vec<3> middle = Vec<3>::Zero(), nominal = Vec<3>::Zero();
    for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
      const Vec<3> contact = on_slope.feet[leg].p_W + ground.ContactArm(robot.foot_radius);
      EXPECT_NEAR(contact[2], ground.HeightAt(contact.head<2>()), 1e-8) << kLegNames[leg];
      middle += on_slope.feet[leg].p_W / kNumLegs;
      nominal += level.feet[leg].p_W / kNumLegs;
    }
    const Eigen::Vector2d com = (level.com_W - nominal).head<2>();
    EXPECT_THAT((on_slope.com_W - middle).head<2>(), IsNear(FootprintOnSlope(ground.slope, 0.8) * com, 1e-8));
    EXPECT_NEAR(on_slope.com_W[2] - ground.HeightAt(on_slope.com_W.head<2>()), level.com_W[2], 1e-8);
  }
}

TEST(StandingTest, TheFeetMayBeShifted) {
  const QuadrupedDescription robot = test::DogBot();
  const GroundPlane ground{.p_W = {0, 0, 0}, .slope = {0.3, 0}};
  const Vec<2> shift(0.08, 0.02);
  QuadrupedDynamics plain, shifted;
  QuadrupedModel(robot).Calc(StandingOn(robot, ground), &plain);
  QuadrupedModel(robot).Calc(StandingOn(robot, ground, 0, shift), &shifted);
  EXPECT_THAT(shifted.com_W, IsNear(plain.com_W, 1e-8));
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    EXPECT_THAT(Vec<3>(shifted.feet[leg].p_W - plain.feet[leg].p_W), IsNear(Vec<3>(0.08, 0.02, 0.024), 1e-8));
}

TEST(StandingTest, NamesTheLegThatDoesNotReach) {
  QuadrupedDescription robot = test::DogBot();
  JointDescription& hip = robot.legs[kRearLeft].joints[1];
  hip.lower = robot.stance[7] - 0.1;
  hip.upper = robot.stance[7] + 0.1;
  const GroundPlane gentle{.p_W = {0, 0, 0}, .slope = {0.05, 0}}, steep{.p_W = {0, 0, 0}, .slope = {0.4, 0}};
  EXPECT_NO_THROW(StandingOn(robot, gentle));
  EXPECT_TRUE(Throws<ParameterError>([&] { StandingOn(robot, steep); }, "rear_left", "dogbot"));
}

QuadrupedDescription Disturbed(const ModelErrorParams& error, std::uint64_t seed = 1) {
  RandomStream random(seed);
  return WithModelError(test::DogBot(), error, random);
}

TEST(WithModelErrorTest, WithoutErrorsTheRobotStaysAsItIs) {
  const QuadrupedDescription robot = test::DogBot(), same = Disturbed({});
  EXPECT_EQ(same.mass(), robot.mass());
  EXPECT_EQ(same.trunk.com, robot.trunk.com);
  EXPECT_EQ(same.FootPosition(kRearLeft, robot.stance), robot.FootPosition(kRearLeft, robot.stance));
}

// Every number has an independent uniform error: over 200 robots its standard deviation is the bound over
// sqrt(3).
TEST(WithModelErrorTest, EachBodyIsOffByItself) {
  const QuadrupedDescription robot = test::DogBot();
  const RigidInertia& thigh = robot.legs[kFrontRight].bodies[1];
  const double thigh_length = robot.legs[kFrontRight].joints[2].p_PJ.norm();
  constexpr int kRobots = 200;
  Eigen::Array4d squares = Eigen::Array4d::Zero();
  double together = 0;  // of the masses of two bodies
  for (std::uint64_t seed = 0; seed < kRobots; ++seed) {
    const QuadrupedDescription other = Disturbed({0.2, 0.05, 0.3, 0.02}, seed);
    const LegDescription& leg = other.legs[kFrontRight];
    const double mass = leg.bodies[1].mass / thigh.mass - 1;
    const Eigen::Array4d errors(mass, (leg.bodies[1].com[1] - thigh.com[1]) / thigh_length,
                                leg.bodies[1].inertia(0, 0) / thigh.inertia(0, 0) / (1 + mass) - 1,
                                leg.joints[2].p_PJ.norm() / thigh_length - 1);
    EXPECT_TRUE((errors.abs() <= Eigen::Array4d(0.2, 0.05, 0.3, 0.02)).all()) << errors.transpose();
    squares += errors.square() / kRobots;
    together += mass * (other.trunk.mass / robot.trunk.mass - 1) / kRobots;
    EXPECT_EQ(other.stance, robot.stance);
    EXPECT_NO_THROW(CheckInertia(leg.bodies[1].inertia));
  }
  const Eigen::Array4d expected = Eigen::Array4d(0.2, 0.05, 0.3, 0.02) / std::sqrt(3);
  EXPECT_TRUE(((squares.sqrt() / expected - 1).abs() < 0.15).all())
      << (squares.sqrt() / expected).transpose();
  EXPECT_LT(std::abs(together), 0.2 * expected[0] * expected[0]);
}

TEST(WithModelErrorTest, TheTrunksCoMIsOffByARatioOfTheDistanceBetweenItsHips) {
  const QuadrupedDescription robot = test::DogBot();
  const double length = robot.legs[kFrontLeft].joints[0].p_PJ[0] - robot.legs[kRearLeft].joints[0].p_PJ[0];
  double most = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    most = std::max(most, std::abs(Disturbed({.com_ratio = 0.1}, seed).trunk.com[0] - robot.trunk.com[0]));
  EXPECT_LE(most, 0.1 * length);
  EXPECT_GT(most, 0.095 * length);
}

TEST(WithModelErrorTest, RefusesImpossibleRatios) {
  EXPECT_TRUE(Throws<ParameterError>([] { Disturbed({.mass_ratio = 1}); }, "mass_ratio"));
  EXPECT_TRUE(Throws<ParameterError>([] { Disturbed({.com_ratio = -0.1}); }, "com_ratio"));
  EXPECT_TRUE(Throws<ParameterError>([] { Disturbed({.inertia_ratio = NAN}); }, "inertia_ratio"));
  EXPECT_TRUE(Throws<ParameterError>([] { Disturbed({.length_ratio = 2}); }, "length_ratio"));
}

}  // namespace tenon::quadruped_model_test
