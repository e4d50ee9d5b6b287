#include <tenon/controllers/legged/planning/centroidal_walk_problem.h>
#include <tenon/controllers/optimization/slq.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tenon::centroidal_walk_problem_test {
namespace {

using Problem = CentroidalWalkProblem;

/// Two feet on the ground, one that lands and one in the air, at a step with a load and a turn.
Problem SomeStep() {
  Problem problem(1);
  Problem::Node& node = problem.nodes[0];
  node.stands = {1, 0, 0, 0.4};
  node.lands = {false, true, false, false};
  node.nominal = {Eigen::Vector2d(0.5, 0.3), Eigen::Vector2d(0.5, -0.3), Eigen::Vector2d(-0.5, 0.3),
                  Eigen::Vector2d(-0.5, -0.3)};
  node.height = {0, 0.02, 0, 0.1};
  node.load << 0.1, -0.2, 0.05, 0.02, 0.01, -0.03;
  node.inverse_inertia = Eigen::Vector3d(12, 5, 4).asDiagonal();
  node.inverse_inertia(0, 1) = node.inverse_inertia(1, 0) = 0.7;
  node.heading = Eigen::Rotation2Dd(0.3).toRotationMatrix();
  node.turn << 0, 0, 0.2;
  problem.edges << 0.5, -0.5, 0, 0, 0, 0, 0.5, -0.5, 1, 1, 1, 1;
  return problem;
}
Problem::State SomeState() {
  Problem::State x;
  x << 0.01, -0.02, 1.03, 0.3, -0.1, 0.05, 0.1, -0.05, 0.02, 0.01, 0.03, -0.02, 0.4, 0.3, 0.5, -0.3, -0.5,
      0.2, -0.4, -0.3;
  return x;
}
Problem::Input SomeInput() {
  Problem::Input u;
  u << 0.1, 0.2, 0.15, 0.05, 0.04, -0.02, 0, 0, 0, 0, 0, 0, 0.3, 0.1, 0.05, 0.2;
  return u;
}

// The step against the closed form of the rigid body under constant forces at points that do not move: the
// CoM on a parabola, the angular momentum by the moment about the moving CoM. Only its term of second order
// in the acceleration, T^3 a x F / 6, is neglected, and a x F vanishes for the sum of the forces without a
// load.
TEST(CentroidalWalkProblem, StepsAreThoseOfARigidBody) {
  Problem problem = SomeStep();
  problem.nodes[0].load.setZero();
  problem.nodes[0].inverse_inertia.setZero();
  const Problem::State x = SomeState();
  const Problem::Input u = SomeInput();
  Problem::State next, fine = x;
  const double T = 0.2;
  problem.Step(0, StepMethod::kMidpoint, T, x, u, next);
  problem.nodes[0].lands[1] = false;
  for (int k = 0; k < 1000; ++k) {
    Problem::State after;
    problem.Step(0, StepMethod::kMidpoint, T / 1000, fine, u, after);
    fine = after;
  }
  EXPECT_LT((next.head<6>() - fine.head<6>()).cwiseAbs().maxCoeff(), 1e-12);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const int leg : {0, 3}) force += problem.Force(0, leg, u);
  const Eigen::Vector3d neglected = T * T * T / 6 * Eigen::Vector3d::UnitZ().cross(force);
  EXPECT_LT((next.segment<3>(9) - fine.segment<3>(9) + neglected).norm(), 1e-6);
}

TEST(CentroidalWalkProblem, DerivativesAreThoseOfDifferences) {
  const Problem problem = SomeStep();
  const Problem::State x = SomeState();
  const Problem::Input u = SomeInput();
  Problem::StepWorkspace workspace(16);
  Problem::Tangent tangent;
  const double T = 0.15;
  problem.LinearizeSteps(StepMethod::kMidpoint, 1, &T, &x, &u, &tangent, workspace);
  for (int j = 0; j < Problem::kStates + Problem::kInputs; ++j) {
    const double h = 1e-6;
    Problem::State x_plus = x, x_minus = x, plus, minus;
    Problem::Input u_plus = u, u_minus = u;
    (j < Problem::kStates ? x_plus[j] : u_plus[j - Problem::kStates]) += h;
    (j < Problem::kStates ? x_minus[j] : u_minus[j - Problem::kStates]) -= h;
    problem.Step(0, StepMethod::kMidpoint, T, x_plus, u_plus, plus);
    problem.Step(0, StepMethod::kMidpoint, T, x_minus, u_minus, minus);
    EXPECT_LT((tangent.col(j) - (plus - minus) / (2 * h)).cwiseAbs().maxCoeff(), 1e-9) << j;
  }
}

}  // namespace
}  // namespace tenon::centroidal_walk_problem_test
