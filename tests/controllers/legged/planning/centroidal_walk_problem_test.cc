#include <tenon/controllers/legged/planning/centroidal_walk_problem.h>
#include <tenon/controllers/optimization/slq.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tenon::centroidal_walk_problem_test {

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

// One step against 1000 short ones. The acceleration a = F - e_z displaces the CoM within the step, whose
// moment T^3/6 a x F is neglected.
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

// A load and a landing: the load accelerates CoM and trunk, the foot lands below the CoM of the next node.
TEST(CentroidalWalkProblem, LoadsAndLandings) {
  const Problem problem = SomeStep();
  const Problem::Node& node = problem.nodes[0];
  const Problem::State x = SomeState();
  Problem::Input u = Problem::Input::Zero();
  u.segment<2>(4) << 0.04, -0.02;
  Problem::State next;
  const double T = 0.1;
  problem.Step(0, StepMethod::kMidpoint, T, x, u, next);
  const Eigen::Vector3d a(0.1, -0.2, 0.05 - 1), L = x.segment<3>(9), tau = node.load.tail<3>();
  const Eigen::Vector3d turned = node.inverse_inertia * (L + T / 2 * tau) - Eigen::Vector3d(0, 0, 0.2);
  EXPECT_LT((next.segment<3>(3) - x.segment<3>(3) - T * a).norm(), 1e-15);
  EXPECT_LT((next.segment<3>(9) - L - T * tau).norm(), 1e-15);
  EXPECT_LT((next.segment<3>(6) - x.segment<3>(6) - T * turned).norm(), 1e-15);
  const Eigen::Vector2d landing = x.head<2>() + T * x.segment<2>(3) + Eigen::Vector2d(0.5, -0.3) +
                                  Eigen::Rotation2Dd(0.3) * Eigen::Vector2d(0.04, -0.02);
  EXPECT_LT((next.segment<2>(14) - landing).norm(), 1e-15);
}

// The costs are quadratic, so gradients and Hessians give differences exactly up to rounding.
TEST(CentroidalWalkProblem, GradientsAreThoseOfTheCosts) {
  Problem problem = SomeStep();
  problem.Q = Problem::State::LinSpaced(0.1, 2);
  problem.Q_f = Problem::State::LinSpaced(3, 1);
  problem.final_divergence = 0.7;
  problem.nodes[0].R = Problem::Input::LinSpaced(0.2, 1);
  problem.nodes[1].x.setConstant(0.05);
  const Problem::State x = SomeState();
  const Problem::Input u = SomeInput();
  Problem::State gx = Problem::State::Zero(), gf = gx;
  Problem::Input gu = Problem::Input::Zero();
  Problem::StateMatrix Hxx = Problem::StateMatrix::Zero(), Hf = Hxx;
  Problem::InputMatrix Huu = Problem::InputMatrix::Zero();
  problem.AddStageCost(0, x, u, 1, gx, gu, Hxx, Huu);
  problem.AddTerminalCost(x, gf, Hf);
  const Problem::State dx = Problem::State::LinSpaced(-0.3, 0.5);
  const Problem::Input du = Problem::Input::LinSpaced(0.4, -0.2);
  EXPECT_NEAR(problem.StageCost(0, x + dx, u + du) - problem.StageCost(0, x, u),
              gx.dot(dx) + gu.dot(du) + dx.dot(Hxx * dx) / 2 + du.dot(Huu * du) / 2, 1e-12);
  EXPECT_NEAR(problem.TerminalCost(x + dx) - problem.TerminalCost(x), gf.dot(dx) + dx.dot(Hf * dx) / 2,
              1e-12);
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

}  // namespace tenon::centroidal_walk_problem_test
