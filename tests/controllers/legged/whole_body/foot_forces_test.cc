#include <tenon/controllers/legged/whole_body/foot_forces.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/SVD>

#include <algorithm>

namespace tenon::foot_forces_test {

using test::DogBot;
using test::RandomState;
using test::RandomVector;

/// s_0^2 - s^2 of a leg, 0 if it is regular.
double Penalty(const Eigen::Matrix3d& J, double min_singular_value) {
  const double s = Eigen::JacobiSVD<Eigen::Matrix3d>(J).singularValues()[2];
  return std::max(0.0, min_singular_value * min_singular_value - s * s);
}

/// Half the gradient of |J^T f - torque|^2 + penalty |f|^2.
Eigen::VectorXd Gradient(const Eigen::MatrixXd& J, const Eigen::VectorXd& torque, double penalty,
                         const Eigen::VectorXd& f) {
  return J * (J.transpose() * f - torque) + penalty * f;
}

TEST(FootForcesTest, AreTheLeastOfTheirPenalisedSquares) {
  constexpr double kMinSingularValue = 0.05;
  const QuadrupedModel model(DogBot());
  RandomStream random(31);
  int regular = 0;
  for (int i = 0; i < 50; ++i) {
    const LeggedState x = RandomState(random);
    const Vec<12> torque = RandomVector<12>(random, 20);
    QuadrupedDynamics dynamics;
    DecoupledDynamics decoupled;
    model.Calc(x, &dynamics);
    model.CalcDecoupled(x, dynamics, &decoupled);

    const FootForces alone = SolveFootForces(dynamics, torque, kMinSingularValue);
    const FootForces together = SolveFootForces(dynamics, decoupled, torque, kMinSingularValue);
    double largest = 0;
    Vec<12> stacked;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Eigen::Matrix3d& J = dynamics.feet[leg].J_leg;
      const double penalty = Penalty(J, kMinSingularValue);
      const Vec<3> tau = torque.segment<3>(3 * leg);
      EXPECT_LT(Gradient(J, tau, penalty, alone[leg]).norm(), 1e-9) << i;
      if (penalty == 0) {
        EXPECT_THAT(Vec<3>(J.transpose() * alone[leg]), IsNear(tau, 1e-9)) << i;
      }
      regular += penalty == 0;
      largest = std::max(largest, penalty);
      stacked.segment<3>(3 * leg) = together[leg];
    }
    EXPECT_LT(Gradient(decoupled.J_q, torque, largest, stacked).norm(), 1e-9) << i;
  }
  EXPECT_GT(regular, 50);
  EXPECT_LT(regular, 150);
}

}  // namespace tenon::foot_forces_test
