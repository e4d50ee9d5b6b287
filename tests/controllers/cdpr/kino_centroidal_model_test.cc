#include <tenon/controllers/cdpr/kino_centroidal_model.h>

#include <gtest/gtest.h>

#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/plants/model/euler.h>
#include <tenon/systems/framework/errors.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/derivative_check.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>

#include <Eigen/LU>

namespace tenon {
namespace {

CdprDescription RobotWith(int cables) {
  CdprDescription robot = test::RobotWithCables(cables);
  robot.inertia_B << 0.3, 0.02, -0.03, 0.02, 0.25, 0.01, -0.03, 0.01, 0.4;
  return robot;
}

CentroidalState SomeState() {
  CentroidalState x;
  x << 0.4, -0.3, 0.2, 0.01, -0.02, 0.03, 0.5, -0.4, 1.8, 0.2, -0.3, 0.5;
  return x;
}

/// A robot of so many cables, and the n of the model.
template <int cables, int n = cables>
struct Cables {
  static constexpr int kCables = cables, kModel = n;
};

template <class Cables>
class KinoCentroidalModelTest : public ::testing::Test {
 public:
  static constexpr int n = Cables::kCables;
  using Model = KinoCentroidalModel<Cables::kModel>;
  const CdprDescription robot = RobotWith(n);
  const Model model{robot};
  const typename Model::Input u = Model::Input::LinSpaced(n, 40, 130);
};

using AllNumbers =
    ::testing::Types<Cables<4>, Cables<5>, Cables<6>, Cables<7>, Cables<8>, Cables<4, Eigen::Dynamic>,
                     Cables<8, Eigen::Dynamic>, Cables<12, Eigen::Dynamic>, Cables<16, Eigen::Dynamic>>;
TYPED_TEST_SUITE(KinoCentroidalModelTest, AllNumbers);

// Newton and Euler with the wrench of the cable kinematics, another piece of code.
TYPED_TEST(KinoCentroidalModelTest, IsNewtonAndEuler) {
  const CentroidalState x = SomeState();
  const Eigen::Vector3d euler = x.tail<3>();
  const Eigen::Matrix3d R_WB = RotationFromEuler(euler);
  const CableKinematics cables = CalcCableKinematics(this->robot, x.segment<3>(6), R_WB);
  const Vector6d wrench = cables.structure * this->u + GravityWrench(this->robot);
  const Eigen::Vector3d w =
      R_WB * this->robot.inertia_B.inverse() * R_WB.transpose() * x.segment<3>(3) * this->robot.mass;
  CentroidalState expected, dx;
  expected << wrench / this->robot.mass, x.head<3>(), EulerRateMatrix(euler).inverse() * w;
  this->model.Derivative(x, this->u, dx);
  EXPECT_THAT(dx, IsNear(expected, 1e-13));
}

TYPED_TEST(KinoCentroidalModelTest, JacobiansAreThoseOfFiniteDifferences) {
  using Model = typename TestFixture::Model;
  const CentroidalState x = SomeState();
  CentroidalState dx, same;
  typename Model::Linearization f(12, TestFixture::n);
  this->model.Linearize(x, this->u, dx, f);
  this->model.Derivative(x, this->u, same);
  EXPECT_THAT(dx, IsNear(same, 1e-13));

  typename Model::Linearization::Tangent jacobian(12, 12 + TestFixture::n);
  f.MultiplyIdentity(jacobian);
  Eigen::Matrix<double, 12 + TestFixture::n, 1> z;
  z << x, this->u;
  const auto rate = [&](const auto& z) -> Eigen::VectorXd {
    CentroidalState out;
    this->model.Derivative(z.template head<12>(), z.template tail<TestFixture::n>(), out);
    return out;
  };
  EXPECT_TRUE(IsJacobian(jacobian, rate, z, 1e-8));
}

TYPED_TEST(KinoCentroidalModelTest, ProductsKnowTheStructure) {
  using Linearization = typename TestFixture::Model::Linearization;
  CentroidalState dx;
  Linearization f(12, TestFixture::n);
  this->model.Linearize(SomeState(), this->u, dx, f);
  typename Linearization::Tangent jacobian = Linearization::Tangent::Zero(12, 12 + TestFixture::n);
  typename Linearization::Tangent rate = jacobian;
  f.MultiplyIdentity(jacobian);
  DenseLinearization<12, TypeParam::kModel> dense(12, TestFixture::n);
  dense.fx = jacobian.template leftCols<12>();
  dense.fu = jacobian.template rightCols<TestFixture::n>();
  const typename Linearization::Tangent tangent = Linearization::Tangent::Random(12, 12 + TestFixture::n);
  typename Linearization::Tangent expected = tangent;
  dense.Multiply(tangent, expected);
  f.Multiply(tangent, rate);
  EXPECT_THAT(rate, IsNear(expected, 1e-12));
}

// With a payload it is the model of the one body that both make, and its Jacobians are those of differences.
TYPED_TEST(KinoCentroidalModelTest, WithAPayloadItIsTheModelOfBoth) {
  using Model = typename TestFixture::Model;
  const LoadedPlatform body(this->robot, {4, {0.1, 0.3, -0.2}});
  CdprDescription both = this->robot;
  both.mass = body.mass;
  both.inertia_B = body.inertia;
  for (CableDescription& cable : both.cables) cable.attachment_B -= body.com_B;
  Model model(this->robot);
  model.SetPayload(this->robot, body);
  const auto rate = [&](const auto& z) -> Eigen::VectorXd {
    CentroidalState out;
    model.Derivative(z.template head<12>(), z.template tail<TestFixture::n>(), out);
    return out;
  };
  Eigen::Matrix<double, 12 + TestFixture::n, 1> z;
  z << SomeState(), this->u;
  CentroidalState dx, expected;
  Model(both).Derivative(SomeState(), this->u, expected);
  typename Model::Linearization f(12, TestFixture::n);
  model.Linearize(SomeState(), this->u, dx, f);
  EXPECT_THAT(dx, IsNear(expected, 1e-13));
  EXPECT_THAT(rate(z), IsNear(expected, 1e-13));
  typename Model::Linearization::Tangent jacobian(12, 12 + TestFixture::n);
  f.MultiplyIdentity(jacobian);
  EXPECT_TRUE(IsJacobian(jacobian, rate, z, 1e-8));
}

// The derivatives of a step are those of that step itself, whatever its length.
TYPED_TEST(KinoCentroidalModelTest, StepsHaveExactDerivatives) {
  using Model = typename TestFixture::Model;
  Eigen::Matrix<double, 12 + TestFixture::n, 1> z;
  z << SomeState(), this->u;
  RungeKutta<Model> step(12, TestFixture::n);
  for (const StepMethod method : {StepMethod::kEuler, StepMethod::kMidpoint, StepMethod::kRungeKutta4}) {
    const auto next = [&](const auto& z) -> Eigen::VectorXd {
      CentroidalState out;
      step.Step(this->model, method, 0.05, z.template head<12>(), z.template tail<TestFixture::n>(), out);
      return out;
    };
    typename RungeKutta<Model>::Tangent tangent(12, 12 + TestFixture::n);
    CentroidalState out;
    step.Step(this->model, method, 0.05, SomeState(), this->u, out, tangent);
    EXPECT_THAT(out, IsNear(next(z), 1e-13));
    EXPECT_TRUE(IsJacobian(tangent, next, z, 1e-8));
  }
}

TEST(KinoCentroidalModel, StateOfAPlatform) {
  const CdprDescription robot = RobotWith(4);
  const Eigen::Vector3d euler(0.1, -0.2, 0.3), w(0.5, 0.6, -0.7);
  PlatformState platform{{1, 2, 3}, QuaternionFromRotation(RotationFromEuler(euler)), {4, 5, 6}, w};
  const CentroidalState x = CentroidalStateOf(robot, platform);
  EXPECT_THAT(x.head<3>(), IsNear(Eigen::Vector3d(4, 5, 6), 0));
  EXPECT_THAT(x.segment<3>(6), IsNear(Eigen::Vector3d(1, 2, 3), 0));
  EXPECT_THAT(x.tail<3>(), IsNear(euler, 1e-14));
  // The model's Euler rate of that state is that of w.
  CentroidalState dx;
  KinoCentroidalModel<4>(robot).Derivative(x, Eigen::Vector4d::Zero(), dx);
  EXPECT_THAT(EulerRateMatrix(euler) * dx.tail<3>(), IsNear(w, 1e-13));
}

// Against differences of both states by the motion that they are states of: place, attitude and their rates.
TEST(KinoCentroidalModel, ErrorsOfThePlatformAreThoseOfItsStateByThatWithThePayload) {
  const CdprDescription robot = RobotWith(4);
  const LoadedPlatform alone(robot, {}), body(robot, {4, {0.1, 0.3, -0.2}});
  Eigen::Matrix<double, 12, 1> rest;
  rest << 0.5, -0.4, 1.8, 0.2, -0.3, 0.5, Eigen::Matrix<double, 6, 1>::Zero();
  const auto jacobian = [&](const LoadedPlatform& of) {
    const auto state = [&](const Eigen::Matrix<double, 12, 1>& z) {
      const Eigen::Vector3d euler = z.segment<3>(3);
      return CentroidalStateOf(of, z.head<3>(), RotationFromEuler(euler), euler, z.segment<3>(6),
                               z.tail<3>());
    };
    constexpr double kStep = 1e-6;
    Eigen::Matrix<double, 12, 12> J;
    for (int i = 0; i < 12; ++i) {
      const Eigen::Matrix<double, 12, 1> step = kStep * Eigen::Matrix<double, 12, 1>::Unit(i);
      J.col(i) = (state(rest + step) - state(rest - step)) / (2 * kStep);
    }
    return J;
  };
  const Eigen::Matrix<double, 12, 12> expected = jacobian(alone) * jacobian(body).inverse();
  EXPECT_THAT(ErrorsOfPlatform(robot, body, rest.segment<3>(3)), IsNear(expected, 1e-8));
  EXPECT_THAT(ErrorsOfPlatform(robot, alone, rest.segment<3>(3)),
              IsNear(Eigen::Matrix<double, 12, 12>::Identity().eval(), 1e-12));
}

TEST(KinoCentroidalModel, RefusesARobotWithAnotherNumberOfCables) {
  EXPECT_TRUE(Throws<ParameterError>([] { KinoCentroidalModel<5> model(test::SixCableRobot()); },
                                     "made for 5 cables", "'six' has 6"));
}

}  // namespace
}  // namespace tenon
