#include <tenon/systems/primitives/matrix_gain.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::matrix_gain_test {

TEST(MatrixGainTest, MultipliesVectorsOfAnySize) {
  Eigen::MatrixXd gain(2, 3);
  gain << 1, 2, 3, 4, 5, 6;
  TestRig<MatrixGain<>> rig({.gain = gain, .y_unit = "N, m", .y_elements = "force, torque"});
  EXPECT_EQ(rig->y.elements()[1].name, "torque");
  EXPECT_EQ(rig->y.elements()[1].unit, "m");
  EXPECT_THAT(rig.Fix(rig->u, Eigen::Vector3d(1, 0, -1))[rig->y], IsNear(Vec<2>(-2, -2), 0));
  rig.Set(rig->gain, 2 * gain);
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(-4, -4), 0));
}

TEST(MatrixGainTest, MultipliesVectorsOfFixedSize) {
  TestRig<MatrixGain<2>> square({.gain = Eigen::Matrix2d{{1, 2}, {3, 4}}});
  EXPECT_THAT(square.Fix(square->u, {1, 1})[square->y], IsNear(Vec<2>(3, 7), 0));
  TestRig<MatrixGain<1, 3>> row({.gain = Eigen::RowVector3d(1, 2, 3)});
  EXPECT_EQ(row.Fix(row->u, {1, 1, 1})[row->y][0], 6);
}

TEST(MatrixGainTest, DoesNotAllocate) {
  DiagramBuilder builder;
  auto& gain = builder.Add<MatrixGain<>>("gain", {.gain = Eigen::MatrixXd::Ones(20, 30)});
  auto& hold = builder.Add<ZeroOrderHold<Eigen::VectorXd>>("hold");
  builder.Connect(gain.y, hold.u);
  Simulator simulator(builder.BuildWithOpenInputs());
  simulator.context().Set(gain.u, Eigen::VectorXd::Ones(30));
  simulator.RunTo(0.1);
  EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(0.2); }), 0);
}

TEST(MatrixGainTest, RefusesWhatDoesNotFit) {
  EXPECT_TRUE(Refuses<MatrixGain<>>({}, "gain"));
  EXPECT_TRUE(Refuses<MatrixGain<>>({.gain = Eigen::MatrixXd::Constant(2, 2, test::kNan)}, "gain"));
  TestRig<MatrixGain<>> rig({.gain = Eigen::MatrixXd::Ones(2, 3)});
  rig.Fix(rig->u, Eigen::Vector2d(1, 2));
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->y]; }, "'block.y'"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { rig.Set(rig->gain, Eigen::MatrixXd::Ones(3, 3)); }, "'block.gain'"));
}

}  // namespace tenon::matrix_gain_test
