#include <tenon/plants/model/model_error.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::model_error_test {
namespace {

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

}  // namespace
}  // namespace tenon::model_error_test
