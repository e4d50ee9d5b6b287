#include <tenon/controllers/legged/whole_body/joint_pd.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <fmt/core.h>

namespace tenon {

void JointPdParams::Validate() const {
  robot.CheckMass();
  Demand(std::isfinite(gravity), fmt::format("gravity = {} must be finite; give m/s^2", gravity));
}

JointPdParams MakeJointPd(const QuadrupedDescription& robot) {
  constexpr double kStiffness = 3.8860629, kDamping = 0.30989852;  // in units of m g l and m g l t
  const RobotScale scale = ScaleOf(robot);
  const double moment = scale.Weight() * scale.length;
  return {.robot = robot, .stiffness = kStiffness * moment, .damping = kDamping * moment * scale.Time()};
}

Vec<12> StandingTorque(const QuadrupedDescription& robot, double gravity) {
  LeggedState x;
  x.q = robot.stance;
  QuadrupedDynamics dynamics;
  QuadrupedModel(robot, gravity).Calc(x, &dynamics);

  // Rows: sum of the forces, and their moments about the CoM around x and y.
  Eigen::Matrix<double, 3, kNumLegs> balance;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const Eigen::Vector3d arm = dynamics.foot(leg).p_W - dynamics.com_W;
    balance.col(leg) << 1, arm[1], -arm[0];
  }
  const LeastSquares normal = SolveLeastSquares(balance, Eigen::Vector3d(robot.mass() * gravity, 0, 0));
  if (normal.rank < 3)
    throw ParameterError(
        fmt::format("the feet of '{}' lie in a line in the nominal stance, in which it cannot stand; change "
                    "nominal_stance",
                    robot.name));

  Vec<12> torque = dynamics.gravity.tail<kNumJoints>();
  for (int leg = 0; leg < kNumLegs; ++leg)
    torque.segment<kJointsPerLeg>(kJointsPerLeg * leg) -=
        dynamics.foot(leg).J_leg.row(2).transpose() * normal.x[leg];
  return torque;
}

JointPd::JointPd(const JointPdParams& p) : LeafSystem(p) {
  if (params.gravity_compensation) feedforward_ = StandingTorque(params.robot, params.gravity);
  for (int j = 0; j < kNumJoints; ++j) limit_[j] = params.robot.joint(j).torque_limit;
}

Vec<12> JointPd::CalcTorque(const JointMotion& joints, const Vec<12>& reference, double stiffness,
                            double damping) const {
  const Vec<12> torque = stiffness * (reference - joints.q) - damping * joints.qd + feedforward_;
  return torque.cwiseMax(-limit_).cwiseMin(limit_);
}

}  // namespace tenon
