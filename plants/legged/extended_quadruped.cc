#include <tenon/plants/legged/extended_quadruped.h>
#include <tenon/plants/legged/quadruped_multibody.h>

namespace tenon {
namespace {

ExtendedRobot MakeExtended(const QuadrupedDescription& robot, double gravity, const ExtendQuadruped& extend,
                           const LeggedState& initial) {
  if (!extend) return {};
  return ExtendedRobot([robot, gravity] { return std::make_unique<QuadrupedMultibody>(robot, gravity); },
                       [extend](RobotMultibody& robot) { extend(static_cast<QuadrupedMultibody&>(robot)); },
                       robot.drive.rotor_inertia, ExtendedQuadruped::MotionOf(initial));
}

}  // namespace

ExtendedQuadruped::ExtendedQuadruped(const QuadrupedDescription& robot, double gravity,
                                     const ExtendQuadruped& extend, const LeggedState& initial)
    : ExtendedRobot(MakeExtended(robot, gravity, extend, initial)) {}

ExtendedRobot::Motion ExtendedQuadruped::MotionOf(const LeggedState& x) {
  return {{x.p_WB, x.q_WB, x.v_W, x.w_W}, {x.q.data(), kNumJoints}, {x.qd.data(), kNumJoints}};
}

void ExtendedQuadruped::CalcRates(const Vec<12>& torque, std::span<const PointForce> forces,
                                  const Eigen::VectorXd& added, ExtendedRates* rates) const {
  Eigen::VectorXd robot;
  ExtendedRobot::CalcRates({torque.data(), kNumJoints}, forces, added, Eigen::Matrix<double, 6, 6>::Zero(),
                           &robot, rates);
  rates->robot = {robot.segment<3>(3), robot.head<3>(), robot.tail<12>()};
}

WrenchEstimate ExtendedQuadruped::MomentumRate(const LeggedAcceleration& acceleration,
                                               const Vec<3>& p_W) const {
  Eigen::VectorXd robot(6 + kNumJoints);
  robot << acceleration.alpha_W, acceleration.a_W, acceleration.qdd;
  const PlatformWrench rate = ExtendedRobot::MomentumRate(robot, p_W);
  return {rate.force_W, rate.torque_W};
}

}  // namespace tenon
