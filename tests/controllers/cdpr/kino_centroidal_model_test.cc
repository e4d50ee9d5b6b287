#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/controllers/cdpr/kino_centroidal_model.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>
#include <tenon/tests/testing/derivative_check.h>

namespace tenon::kino_centroidal_model_test {

/// Those with five and with eight cables have springs, too.
CdprDescription RobotWith(int cables) {
  CdprDescription robot = test::RobotWithCables(cables);
  if (cables == 5 || cables == 8) robot = test::WithSprings(robot);
  robot.inertia_B << 0.3, 0.02, -0.03, 0.02, 0.25, 0.01, -0.03, 0.01, 0.4;
  return robot;
}

CentroidalState SomeState() {
  CentroidalState x;
  x << 0.4, -0.3, 0.2, 0.01, -0.02, 0.03, 0.5, -0.4, 1.8, 0.2, -0.3, 0.5;
  return x;
}

/// The Jacobian (fx fu) of the model, from a step of Euler.
template <int n>
Eigen::MatrixXd JacobianOf(const KinoCentroidalModel<n>& model, const CentroidalState& x,
                           const typename KinoCentroidalModel<n>::Input& u) {
  const double h = 1;
  typename KinoCentroidalModel<n>::Tangent tangent(12, 12 + u.size());
  RungeKutta<KinoCentroidalModel<n>>(12, static_cast<int>(u.size()))
      .Linearize(model, StepMethod::kEuler, 1, &h, &x, &u, &tangent);
  Eigen::MatrixXd jacobian = tangent;
  jacobian.diagonal().array() -= 1;
  return jacobian;
}

/// The number of cables, and the n of the model.
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
    ::testing::Types<Cables<4>, Cables<8>, Cables<4, Eigen::Dynamic>, Cables<5, Eigen::Dynamic>,
                     Cables<6, Eigen::Dynamic>, Cables<7, Eigen::Dynamic>, Cables<12, Eigen::Dynamic>>;
TYPED_TEST_SUITE(KinoCentroidalModelTest, AllNumbers);

// Newton's and Euler's equations with the wrench of the cable kinematics.
TYPED_TEST(KinoCentroidalModelTest, IsNewtonAndEuler) {
  const CentroidalState x = SomeState();
  const Eigen::Vector3d euler = x.tail<3>();
  const Eigen::Matrix3d R_WB = RotationFromEuler(euler);
  const CableKinematics cables = CalcCableKinematics(this->robot, x.segment<3>(6), R_WB);
  const Vector6d wrench = cables.structure * this->u + PassiveWrench(this->robot, x.segment<3>(6), R_WB);
  const Eigen::Vector3d w =
      R_WB * test::Solve(this->robot.inertia_B, R_WB.transpose() * x.segment<3>(3) * this->robot.mass);
  CentroidalState expected, dx;
  expected << wrench / this->robot.mass, x.head<3>(), test::Solve(EulerRateMatrix(euler), w);
  this->model.Derivative(x, this->u, dx);
  EXPECT_THAT(dx, IsNear(expected, 1e-13));
}

// With pulleys the model is exact at the pose of SetPose.
TYPED_TEST(KinoCentroidalModelTest, ModelsPulleys) {
  const CentroidalState x = SomeState();
  const Eigen::Matrix3d R_WB = RotationFromEuler(x.tail<3>());
  for (const bool on_platform : {false, true}) {
    CdprDescription robot = this->robot;
    robot.winch.pulley_radius = 0.1;
    robot.winch.pulleys_on_platform = on_platform;
    typename TestFixture::Model model(robot);
    model.SetPose(robot, x.segment<3>(6), R_WB);
    const Vector6d wrench = CalcCableKinematics(robot, x.segment<3>(6), R_WB).structure * this->u +
                            PassiveWrench(robot, x.segment<3>(6), R_WB);
    CentroidalState dx;
    model.Derivative(x, this->u, dx);
    EXPECT_THAT(dx.head<6>(), IsNear(wrench / robot.mass, 1e-13));
    this->model.Derivative(x, this->u, dx);
    EXPECT_GT((dx.head<6>() - wrench / robot.mass).norm(), 0.1);
  }
}

// With a payload it is the model of platform and payload as one body.
TYPED_TEST(KinoCentroidalModelTest, WithAPayloadItIsTheModelOfBoth) {
  using Model = typename TestFixture::Model;
  const LoadedPlatform body(this->robot, {4, {0.1, 0.3, -0.2}});
  CdprDescription both = this->robot;
  both.mass = body.mass;
  both.inertia_B = body.inertia;
  for (CableDescription& cable : both.cables) cable.attachment_B -= body.com_B;
  for (SpringDescription& spring : both.springs) spring.attachment_B -= body.com_B;
  Model model(this->robot);
  model.SetPayload(this->robot, body);
  const auto rate = [&](const auto& z) -> Eigen::VectorXd {
    CentroidalState out;
    model.Derivative(z.template head<12>(), z.template tail<TestFixture::n>(), out);
    return out;
  };
  Eigen::Matrix<double, 12 + TestFixture::n, 1> z;
  z << SomeState(), this->u;
  CentroidalState expected;
  Model(both).Derivative(SomeState(), this->u, expected);
  EXPECT_THAT(rate(z), IsNear(expected, 1e-13));
  EXPECT_TRUE(IsJacobian(JacobianOf<TypeParam::kModel>(model, SomeState(), this->u), rate, z, 1e-8));
}

/// The model without steps of its own, so that RungeKutta makes them.
template <class Model>
struct RateOnly {
  static constexpr int kStates = 12, kInputs = Model::kInputs;
  using Linearization = DenseLinearization<12, kInputs>;
  const Model& model;
  void Derivative(const CentroidalState& x, const typename Model::Input& u, CentroidalState& dx) const {
    model.Derivative(x, u, dx);
  }
};

TYPED_TEST(KinoCentroidalModelTest, StepsAreThoseOfRungeKutta) {
  using Model = typename TestFixture::Model;
  RungeKutta<RateOnly<Model>> plain(12, TestFixture::n);
  RungeKutta<Model> own(12, TestFixture::n);
  for (const StepMethod method : {StepMethod::kEuler, StepMethod::kMidpoint, StepMethod::kRungeKutta4}) {
    CentroidalState expected, next;
    plain.Step({this->model}, 0, method, 0.05, SomeState(), this->u, expected);
    own.Step(this->model, 0, method, 0.05, SomeState(), this->u, next);
    EXPECT_THAT(next, IsNear(expected, 1e-14));
  }
}

// The Jacobians of steps of any length against finite differences; seven steps, because four are computed at
// once.
TYPED_TEST(KinoCentroidalModelTest, StepsHaveExactDerivatives) {
  using Model = typename TestFixture::Model;
  constexpr int kSteps = 7, n = TestFixture::n;
  std::vector<double> h;
  std::vector<CentroidalState> x;
  std::vector<typename Model::Input> u;
  for (int k = 0; k < kSteps; ++k) {
    h.push_back(0.01 + 0.01 * k);
    x.push_back(SomeState() * (1 - 0.2 * k));
    u.push_back(this->u * (1 + 0.1 * k));
  }
  RungeKutta<Model> step(12, n);
  for (const StepMethod method : {StepMethod::kEuler, StepMethod::kMidpoint, StepMethod::kRungeKutta4}) {
    using Tangent = typename RungeKutta<Model>::Tangent;
    std::vector<Tangent> tangents(kSteps, Tangent::Zero(12, 12 + n));
    step.Linearize(this->model, method, kSteps, h.data(), x.data(), u.data(), tangents.data());
    for (int k = 0; k < kSteps; ++k) {
      const auto next = [&](const auto& z) -> Eigen::VectorXd {
        CentroidalState out;
        step.Step(this->model, k, method, h[k], z.template head<12>(), z.template tail<n>(), out);
        return out;
      };
      Eigen::Matrix<double, 12 + n, 1> z;
      z << x[k], u[k];
      EXPECT_TRUE(IsJacobian(tangents[k], next, z, 1e-8)) << k;
      Tangent alone = Tangent::Zero(12, 12 + n);
      step.Linearize(this->model, method, 1, &h[k], &x[k], &u[k], &alone);
      EXPECT_THAT(tangents[k], IsNear(alone, 0)) << k;
    }
  }
}

// Beyond the range of the sine and cosine of lanes.h.
TEST(KinoCentroidalModel, IsNotFiniteOutsideItsRange) {
  const KinoCentroidalModel<4> model(RobotWith(4));
  const Eigen::Vector4d u(50, 60, 70, 80);
  CentroidalState x = SomeState(), next;
  model.Step(0, StepMethod::kMidpoint, 0.01, x, u, next);
  EXPECT_TRUE(next.allFinite());
  for (const double angle : {1.1e6, -1e300, std::numeric_limits<double>::infinity()}) {
    x[11] = angle;
    model.Step(0, StepMethod::kMidpoint, 0.01, x, u, next);
    EXPECT_FALSE(next.allFinite()) << angle;
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

// Against finite differences of both states with respect to pose and velocity.
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
  const Eigen::Matrix<double, 12, 12> expected = jacobian(alone) * test::Inverse(jacobian(body));
  EXPECT_THAT(ErrorsOfPlatform(robot, body, rest.segment<3>(3)), IsNear(expected, 1e-8));
  EXPECT_THAT(ErrorsOfPlatform(robot, alone, rest.segment<3>(3)),
              IsNear(Eigen::Matrix<double, 12, 12>::Identity().eval(), 1e-12));
}

TEST(KinoCentroidalModel, RefusesARobotWithAnotherNumberOfCables) {
  EXPECT_TRUE(
      Throws<ParameterError>([] { KinoCentroidalModel<8> model(test::SixCableRobot()); }, "'six'", "8", "6"));
}

// At each node of a horizon, the model has the anchors of that node.
TYPED_TEST(KinoCentroidalModelTest, HasTheAnchorsOfEachNode) {
  using Model = typename TestFixture::Model;
  constexpr int kNodes = 6;
  const CdprDescription robot = test::WithMovingAnchors(this->robot);
  const MovingAnchors anchors(robot);
  Model model(robot);
  model.SeparateNodes(kNodes);
  const CentroidalState x = SomeState();
  const double h[kNodes] = {0.01, 0.02, 0.02, 0.03, 0.03, 0.04};
  std::vector<CentroidalState> states(kNodes, x);
  std::vector<typename Model::Input> inputs(kNodes, this->u);
  const typename Model::Tangent empty = Model::Tangent::Zero(12, 12 + TestFixture::n);
  std::vector<typename Model::Tangent> tangents(kNodes, empty);
  for (int k = 0; k < kNodes; ++k)
    model.SetAnchors(k, robot, anchors, 0.15 * k, x.segment<3>(6), RotationFromEuler(x.tail<3>()));
  RungeKutta<Model> all(12, TestFixture::n), one(12, TestFixture::n);
  all.Linearize(model, StepMethod::kRungeKutta4, kNodes, h, states.data(), inputs.data(), tangents.data());
  double change = 0;
  for (int k = 0; k < kNodes; ++k) {
    const Model there(anchors.RobotAt(robot, 0.15 * k));
    typename Model::Tangent tangent = empty;
    one.Linearize(there, StepMethod::kRungeKutta4, 1, h + k, &x, &this->u, &tangent);
    EXPECT_THAT(tangents[k], IsNear(tangent, 1e-12)) << k;
    CentroidalState next, expected;
    all.Step(model, k, StepMethod::kRungeKutta4, h[k], x, this->u, next);
    one.Step(there, 0, StepMethod::kRungeKutta4, h[k], x, this->u, expected);
    EXPECT_THAT(next, IsNear(expected, 1e-13)) << k;
    one.Step(this->model, 0, StepMethod::kRungeKutta4, h[k], x, this->u, expected);
    change = std::max(change, (next - expected).norm());
  }
  EXPECT_GT(change, 1e-3);
}

}  // namespace tenon::kino_centroidal_model_test
