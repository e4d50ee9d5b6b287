#include <tenon/plants/cdpr/cdpr_multibody.h>
#include <tenon/plants/cdpr/extended_platform.h>
#include <tenon/plants/legged/extended_quadruped.h>
#include <tenon/plants/legged/quadruped_multibody.h>
#include <tenon/plants/multibody/internal/simbody_conversions.h>
#include <tenon/plants/multibody/robot_multibody.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

namespace tenon {

using internal::MassOf;
using internal::NearestName;
using internal::ToSimbody;

RobotMultibody::RobotMultibody(const RigidInertia& base, double gravity) : base_(base) {
  forces.setNumberOfThreads(1);
  SimTK::Force::Gravity(forces, matter, SimTK::Vec3(0, 0, -gravity));
  bodies_.push_back(SimTK::MobilizedBody::Free(matter.Ground(), SimTK::Transform(),
                                               SimTK::Body::Rigid(MassOf(base)), SimTK::Transform()));
}

void RobotMultibody::Replace(const RigidInertia& part) {
  replaced_ = replaced_ + part;
  if (replaced_.mass == 0) return;
  const RigidInertia rest = base_ + RigidInertia{-replaced_.mass, replaced_.com, -replaced_.inertia};
  if (!(rest.mass > 0))
    throw ParameterError(fmt::format(
        "the added bodies replace {} kg of a trunk or platform of {} kg; give bodies that are parts of it",
        replaced_.mass, base_.mass));
  CheckInertia(rest.inertia);
  base().setDefaultMassProperties(MassOf(rest));
}

void RobotMultibody::Name(const SimTK::MobilizedBody& added, const std::string& name) {
  if (name.empty() || name.find(',') != std::string::npos)
    throw ParameterError(fmt::format("an added joint has the name '{}'; give a name without commas", name));
  const int index = added.getMobilizedBodyIndex();
  for (const auto& [other, used] : names_)
    if (used == name && other != index)
      throw ParameterError(
          fmt::format("two added joints have the name '{}'; give each a name of its own", name));
  names_[index] = name;
}

QuadrupedMultibody::QuadrupedMultibody(const QuadrupedDescription& robot, double gravity)
    : RobotMultibody(robot.trunk, gravity) {
  bodies_.reserve(1 + kNumJoints);  // `base` and `link` return references
  for (std::size_t j = 0; j < kNumJoints; ++j) {
    const std::size_t leg = j / kJointsPerLeg, i = j % kJointsPerLeg;
    const JointDescription& joint = robot.legs[leg].joints[i];
    const SimTK::Rotation R(SimTK::UnitVec3(ToSimbody(joint.axis)), SimTK::ZAxis);  // a Pin turns about z
    bodies_.push_back(SimTK::MobilizedBody::Pin(
        bodies_[i == 0 ? 0 : j], SimTK::Transform(R, ToSimbody(joint.p_PJ)),
        SimTK::Body::Rigid(MassOf(robot.legs[leg].bodies[i])), SimTK::Transform(R)));
    joints_[j] = joint.name;
  }
}

SimTK::MobilizedBody& QuadrupedMultibody::link(const std::string& joint) {
  for (std::size_t j = 0; j < kNumJoints; ++j)
    if (joints_[j] == joint) return bodies_[1 + j];
  const std::string nearest = NearestName(joint, {joints_.begin(), joints_.end()});
  throw ParameterError(
      fmt::format("the robot has no joint '{}'{}; give the name of one of the twelve joints of its legs",
                  joint, nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
}

namespace {

/// The robot with the additions of `extend`; without these, no robot.
template <class Multibody, class Description>
ExtendedRobot MakeExtended(const Description& robot, double gravity,
                           const std::function<void(Multibody&)>& extend, double rotor_inertia,
                           const ExtendedRobot::Motion& initial) {
  if (!extend) return {};
  return ExtendedRobot([robot, gravity] { return std::make_unique<Multibody>(robot, gravity); },
                       [extend](RobotMultibody& robot) { extend(static_cast<Multibody&>(robot)); },
                       rotor_inertia, initial);
}

}  // namespace

ExtendedQuadruped::ExtendedQuadruped(const QuadrupedDescription& robot, double gravity,
                                     const ExtendQuadruped& extend, const LeggedState& initial)
    : ExtendedRobot(MakeExtended(robot, gravity, extend, robot.drive.rotor_inertia, MotionOf(initial))) {}

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

ExtendedRobot ExtendedPlatform(const CdprDescription& robot, double gravity, const ExtendCdpr& extend,
                               const PlatformState& initial) {
  return MakeExtended(robot, gravity, extend, 0, {initial});
}

}  // namespace tenon
