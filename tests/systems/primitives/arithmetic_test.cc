// Blocks without memory.

#include <tenon/systems/primitives/adder.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/quantizer.h>
#include <tenon/systems/primitives/saturation.h>
#include <tenon/systems/primitives/table.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::arithmetic_test {

TEST(AdderTest, Weighs) {
  TestRig<Adder<Vec<2>>> rig({.weights = {1, -1, 0.5}});
  auto& u = rig->u;
  rig.Fix(u[0], {1, 2}).Fix(u[1], {3, 5}).Fix(u[2], {4, -4});
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(0, -5), 0));
}

TEST(AdderTest, TakesManyInputs) {
  const std::vector<double> weights = {1, 2, 3, 4, 5};
  TestRig<Adder<>> rig({.weights = weights});
  for (std::size_t i = 0; i < weights.size(); ++i) rig.Fix(rig->u[i], 1);
  EXPECT_EQ(rig[rig->y], 15);
  rig.Set(rig->weights, {1, 1, 1, 1, 0});
  EXPECT_EQ(rig[rig->y], 4);
  EXPECT_EQ(rig.context().Clone()->EvalDoubles(rig->weights), (std::vector<double>{1, 1, 1, 1, 0}));
}

TEST(AdderTest, WeightsAreSaved) {
  TestRig<Adder<>> two, one;
  two.Set(two->weights, {3, -1});
  one.Set(one->weights, {5});
  one.context().Restore(two.context().Save());
  EXPECT_EQ(one[one->weights], (std::vector<double>{3, -1}));
}

TEST(AdderTest, RefusesBadWeights) {
  EXPECT_TRUE(Refuses<Adder<>>({.weights = {}}, "weights"));
  EXPECT_TRUE(Refuses<Adder<>>({.weights = {1, test::kInfinity}}, "weights"));
}

TEST(AdderTest, RefusesAnotherNumberOfWeightsInARun) {
  TestRig<Adder<>> rig;
  rig.Fix(rig->u[0], 3).Fix(rig->u[1], 4).Set(rig->weights, {1});
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->y]; }, "'block.y'"));
}

TEST(ConstantSourceTest, GivesItsValue) {
  TestRig<ConstantSource<Vec<2>>> rig({.value = {1, 2}, .unit = "N"});
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.RunTo(10)[rig->y], IsNear(Vec<2>(1, 2), 0));
}

TEST(ConstantSourceTest, GivesVectorsOfAnySize) {
  TestRig<ConstantSource<std::vector<double>>> rig({.value = {1, 2, 3}});
  EXPECT_EQ(rig[rig->y], (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(rig->y.elements().size(), 3u);
}

TEST(GainTest, Multiplies) {
  TestRig<Gain<>> rig({.gain = -2.5});
  EXPECT_EQ(rig.Fix(rig->u, 4)[rig->y], -10);
}

TEST(GainTest, CarriesNamesOfElements) {
  TestRig<Gain<Vec<2>>> rig({.gain = 2, .elements = "x, z"});
  EXPECT_EQ(rig->y.elements()[1].name, "z");
}

TEST(MatrixGainTest, MultipliesVectorsOfAnySize) {
  Eigen::MatrixXd gain(2, 3);
  gain << 1, 2, 3, 4, 5, 6;
  TestRig<MatrixGain<>> rig({.gain = gain, .y_unit = "N, m", .y_elements = "force, torque"});
  EXPECT_EQ(rig->y.elements()[1].name, "torque");
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
  TestRig<MatrixGain<>> rig({.gain = Eigen::MatrixXd::Ones(2, 3)});
  rig.Fix(rig->u, Eigen::Vector2d(1, 2));
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->y]; }, "'block.y'"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { rig.Set(rig->gain, Eigen::MatrixXd::Ones(3, 3)); }, "'block.gain'"));
}

TEST(QuantizerTest, RoundsToTheNearestStep) {
  TestRig<Quantizer<Vec<3>>> rig({.step = {0.25, 2, 1}});
  EXPECT_THAT(rig.Fix(rig->u, {0.6, 2.9, -1.5})[rig->y], IsNear(Vec<3>(0.5, 2, -2), 0));
  rig.Set(rig->step, {1, 1, 1});
  EXPECT_THAT(rig[rig->y], IsNear(Vec<3>(1, 3, -2), 0));
}

TEST(SaturationTest, IsOpenByDefault) {
  TestRig<Saturation<>> rig({.upper = 2});
  EXPECT_EQ(rig.Fix(rig->u, -1e300)[rig->y], -1e300);
  EXPECT_EQ(rig.Fix(rig->u, 1e300)[rig->y], 2);
}

TEST(SaturationTest, LimitsElementByElement) {
  TestRig<Saturation<Vec<2>>> rig({.lower = {-1, -10}, .upper = {1, 10}});
  EXPECT_THAT(rig.Fix(rig->u, {5, 5})[rig->y], IsNear(Vec<2>(1, 5), 0));
  EXPECT_THAT(rig.Fix(rig->u, {-5, -50})[rig->y], IsNear(Vec<2>(-1, -10), 0));
}

TEST(SaturationTest, AnyElementChangesThePiece) {
  TestRig<Saturation<Vec<3>>> rig({.lower = Vec<3>(-1, -1, -1), .upper = Vec<3>(1, 1, 1)});
  const std::int64_t inside = rig.Fix(rig->u, Vec<3>(0, 0, 0))[rig->kink];
  for (int i = 0; i < 3; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const Vec<3> outside = 2 * side * Vec<3>::Unit(i);
      EXPECT_NE(rig.Fix(rig->u, outside)[rig->kink], inside) << i << ' ' << side;
    }
  }
}

TEST(SaturationTest, DoesNotHideNan) {
  TestRig<Saturation<>> rig({.lower = -1, .upper = 2});
  EXPECT_TRUE(std::isnan(rig.Fix(rig->u, test::kNan)[rig->y]));
}

TEST(SaturationTest, RefusesCrossedLimits) {
  EXPECT_TRUE(Refuses<Saturation<>>({.lower = 1, .upper = 0}, "lower"));
  EXPECT_TRUE(Refuses<Saturation<Vec<2>>>({.lower = {0, 3}, .upper = {1, 2}}, "upper"));
  EXPECT_TRUE(Refuses<Saturation<>>({.upper = test::kNan}, "lower"));
}

TEST(TableTest, InterpolatesAndClamps) {
  TestRig<Table<>> rig({.u = {-1, 0, 2, 3}, .y = {5, 1, 2, -4}});
  const double points[][2] = {{-9, 5}, {-1, 5},   {-0.75, 4}, {0, 1}, {0.5, 1.25},
                              {2, 2},  {2.5, -1}, {3, -4},    {9, -4}};
  for (const auto& [u, y] : points) EXPECT_EQ(rig.Fix(rig->u, u)[rig->y], y) << "at " << u;
}

TEST(TableTest, GivesVectors) {
  TestRig<Table<Vec<2>>> rig({.u = {0, 1}, .y = {{0, 10}, {1, 20}}});
  EXPECT_THAT(rig.Fix(rig->u, 0.25)[rig->y], IsNear(Vec<2>(0.25, 12.5), 1e-15));
}

TEST(TableTest, DoesNotHideNan) {
  TestRig<Table<>> rig({.u = {0, 1}, .y = {2, 4}});
  EXPECT_TRUE(std::isnan(rig.Fix(rig->u, test::kNan)[rig->y]));
}

TEST(TableTest, RefusesBadPoints) {
  EXPECT_TRUE(Refuses<Table<>>({}, "two points"));
  EXPECT_TRUE(Refuses<Table<>>({.u = {0}, .y = {0}}, "two points"));
  EXPECT_TRUE(Refuses<Table<>>({.u = {0, 1}, .y = {0, 1, 2}}, "2 u and 3 y"));
  EXPECT_TRUE(Refuses<Table<>>({.u = {0, 1, 1}, .y = {0, 1, 2}}, "u must increase"));
  EXPECT_TRUE(Refuses<Table<>>({.u = {0, 1}, .y = {0, test::kNan}}, "finite"));
}

}  // namespace tenon::arithmetic_test
