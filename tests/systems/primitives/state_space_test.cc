#include <tenon/systems/primitives/state_space.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::state_space_test {

/// The oscillator q'' = -4 q + u, its position and velocity.
StateSpaceParams Oscillator() {
  return {.A = Eigen::MatrixXd{{0, 1}, {-4, 0}},
          .B = Eigen::MatrixXd{{0}, {1}},
          .C = Eigen::MatrixXd::Identity(2, 2),
          .initial = Eigen::Vector2d(1, 0),
          .u_unit = "N/kg",
          .x_unit = "m, m/s",
          .y_unit = "m, m/s",
          .x_elements = "q, v"};
}

TEST(StateSpaceTest, IsIntegrated) {
  TestRig<StateSpace> rig(Oscillator());
  EXPECT_EQ(rig.diagram().ContinuousStateNames()[1], "block.x.v");
  rig.Fix(rig->u, Eigen::VectorXd::Constant(1, 2)).RunTo(0.7);
  // An oscillation about the equilibrium at u / 4.
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(0.5 + 0.5 * std::cos(1.4), -std::sin(1.4)), 1e-9));
}

TEST(StateSpaceTest, HasFeedthroughOnlyIfThereIsAD) {
  const auto build = [](StateSpaceParams params) {
    DiagramBuilder builder;
    auto& plant = builder.Add<StateSpace>("plant", std::move(params));
    builder.Connect(plant.y, plant.u);
    return builder.Build();
  };
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  EXPECT_NO_THROW(build({.A = one, .B = one, .C = one}));
  EXPECT_TRUE(Throws<BuildError>([&] { build({.A = one, .B = one, .C = one, .D = one}); }, "algebraic loop"));
  TestRig<StateSpace> rig({.A = one, .B = one, .C = 2 * one, .D = 3 * one, .initial = one});
  EXPECT_EQ(rig.Fix(rig->u, 5 * one)[rig->y][0], 17);
  rig.Set(rig->D, -one);
  EXPECT_EQ(rig[rig->y][0], -3);
}

TEST(StateSpaceTest, MatricesAreSetInARun) {
  TestRig<StateSpace> rig(Oscillator());
  rig.Fix(rig->u, Eigen::VectorXd::Zero(1));
  EXPECT_THAT(rig.Derivative(rig->x), IsNear(Vec<2>(0, -4), 0));
  rig.Set(rig->A, Eigen::Matrix2d{{0, 1}, {-9, 0}});
  EXPECT_THAT(rig.Derivative(rig->x), IsNear(Vec<2>(0, -9), 0));
}

TEST(StateSpaceTest, RefusesInARunWhatDoesNotFit) {
  TestRig<StateSpace> rig(Oscillator());
  rig.Fix(rig->u, Eigen::Vector2d(1, 2));
  EXPECT_TRUE(Throws<RunError>([&] { rig.Derivative(rig->x); }, "block"));
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->C, Eigen::MatrixXd::Zero(3, 2)); }, "'block.C'"));
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->D, Eigen::MatrixXd::Zero(2, 1)); }, "'block.D'"));
}

TEST(StateSpaceTest, RefusesMatricesThatDoNotFit) {
  const auto refuses = [](auto change, const char* matrix) {
    StateSpaceParams params = Oscillator();
    change(params);
    return Refuses<StateSpace>(params, matrix);
  };
  EXPECT_TRUE(Refuses<StateSpace>({}, "A must be square"));
  EXPECT_TRUE(refuses([](auto& p) { p.A.resize(2, 3); }, "A must be square"));
  EXPECT_TRUE(refuses([](auto& p) { p.B.resize(3, 1); }, "B must"));
  EXPECT_TRUE(refuses([](auto& p) { p.C.resize(1, 3); }, "C must"));
  EXPECT_TRUE(refuses([](auto& p) { p.D.resize(1, 1); }, "D must"));
  EXPECT_TRUE(refuses([](auto& p) { p.initial.resize(3); }, "initial must"));
  EXPECT_TRUE(refuses([](auto& p) { p.B(1, 0) = test::kNan; }, "finite"));
  EXPECT_TRUE(Refuses<DiscreteStateSpace>({}, "A must be square"));
}

TEST(DiscreteStateSpaceTest, StepsByItsMatrices) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  TestRig<DiscreteStateSpace> rig(
      {.model = {.A = 0.5 * one, .B = one, .C = 2 * one, .D = one, .initial = 3 * one}, .rate = Hz(10)});
  rig.Fix(rig->u, one);
  // x = 2 + 0.5^n
  for (int n = 0; n < 10; ++n) EXPECT_EQ(rig.Tick()[rig->y][0], 2 * (2 + std::pow(0.5, n)) + 1);
}

TEST(DiscreteStateSpaceTest, BreaksLoopsWithoutD) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
  DiagramBuilder builder;
  auto& plant =
      builder.Add<DiscreteStateSpace>("plant", {.model = {.A = one, .B = one, .C = one, .initial = one}});
  builder.Connect(plant.y, plant.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(0.01);  // doubles every millisecond
  EXPECT_EQ(simulator.context().Eval(plant.y)[0], 1024);
}

}  // namespace tenon::state_space_test
