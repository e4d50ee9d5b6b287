#include <tenon/plants/model/quadruped_description.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <numbers>

namespace tenon {

namespace {

/// A point of the leg's body i, given in that body's frame, in the trunk's frame B.
Eigen::Vector3d PointInTrunk(const LegDescription& leg, int i, Eigen::Vector3d p,
                             const Vec<kJointsPerLeg>& q) {
  for (; i >= 0; --i) {
    const JointDescription& joint = leg.joints[i];
    p = joint.p_PJ + Eigen::AngleAxisd(q[i], joint.axis) * p;
  }
  return p;
}

}  // namespace

double QuadrupedDescription::mass() const {
  double sum = trunk.mass;
  for (const LegDescription& leg : legs)
    for (const RigidInertia& body : leg.bodies) sum += body.mass;
  return sum;
}

void QuadrupedDescription::CheckMass() const {
  if (!(mass() > 0)) throw ParameterError("the robot has no mass; give a robot, as LoadQuadruped reads it");
}

Eigen::Vector3d QuadrupedDescription::HipPosition(int leg, const Vec<kNumJoints>& q) const {
  const LegDescription& at = legs[leg];
  return PointInTrunk(at, 0, at.joints[1].p_PJ, q.segment<kJointsPerLeg>(kJointsPerLeg * leg));
}

double QuadrupedDescription::LegLength(int leg) const {
  const LegDescription& at = legs[leg];
  return at.joints[2].p_PJ.norm() + at.foot_J.norm();
}

double QuadrupedDescription::LongestExtension(int leg) const {
  const auto& [joints, bodies, foot] = legs[leg];
  const JointDescription& knee = joints[2];
  // The knee's angle of a straight leg, within a turn of the middle of a finite range.
  double straight = std::atan2(knee.axis.dot(foot.cross(knee.p_PJ)), foot.dot(knee.p_PJ));
  if (!std::isfinite(knee.lower) || !std::isfinite(knee.upper)) return LegLength(leg);
  const double middle = (knee.lower + knee.upper) / 2;
  straight += 2 * std::numbers::pi * std::round((middle - straight) / (2 * std::numbers::pi));
  if (knee.lower <= straight && straight <= knee.upper) return LegLength(leg);
  const double end = straight > knee.upper ? knee.upper : knee.lower;
  return (knee.p_PJ + Eigen::AngleAxisd(end, knee.axis) * foot).norm();
}

Eigen::Vector3d QuadrupedDescription::FootPosition(int leg, const Vec<kNumJoints>& q) const {
  const LegDescription& at = legs[leg];
  return PointInTrunk(at, kJointsPerLeg - 1, at.foot_J, q.segment<kJointsPerLeg>(kJointsPerLeg * leg));
}

LegPose QuadrupedDescription::PoseOfLeg(int leg, const Vec<kNumJoints>& q) const {
  const LegDescription& at = legs[leg];
  LegPose pose;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int i = 0; i < kJointsPerLeg; ++i) {
    const JointDescription& joint = at.joints[i];
    p += R * joint.p_PJ;
    R = R * Eigen::AngleAxisd(q[kJointsPerLeg * leg + i], joint.axis);
    pose.p_BJ[i] = p;
    pose.R_BJ[i] = R;
  }
  pose.foot_B = p + R * at.foot_J;
  return pose;
}

double QuadrupedDescription::StanceHeight() const {
  double sum = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) sum += foot_radius - FootPosition(leg, stance)[2];
  return sum / kNumLegs;
}

QuadrupedDescription WithPayload(QuadrupedDescription robot, const RigidInertia& payload) {
  if (!(payload.mass >= 0))
    throw ParameterError(
        fmt::format("the payload's mass is {} kg but must not be negative; give 0 for none", payload.mass));
  if (payload.mass > 0) robot.trunk = robot.trunk + payload;
  return robot;
}

QuadrupedDescription WithMassFactor(QuadrupedDescription robot, double factor) {
  if (!(std::isfinite(factor) && factor > 0))
    throw ParameterError(fmt::format(
        "the mass factor is {} but must be finite and positive; 1 keeps the robot's masses", factor));
  const auto scale = [factor](RigidInertia& body) {
    body.mass *= factor;
    body.inertia *= factor;
  };
  scale(robot.trunk);
  for (LegDescription& leg : robot.legs) std::for_each(leg.bodies.begin(), leg.bodies.end(), scale);
  return robot;
}

RobotScale ScaleOf(const QuadrupedDescription& robot, double gravity) {
  double length = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) length += robot.LegLength(leg) / kNumLegs;
  return {robot.mass(), length, gravity};
}

namespace {

double TrunkLength(const QuadrupedDescription& robot) {
  const auto hip = [&](Leg leg) -> const Eigen::Vector3d& { return robot.legs[leg].joints[0].p_PJ; };
  return (hip(kFrontLeft) + hip(kFrontRight) - hip(kRearLeft) - hip(kRearRight)).norm() / 2;
}

}  // namespace

QuadrupedDescription WithModelError(QuadrupedDescription robot, const ModelErrorParams& error,
                                    RandomStream& random) {
  CheckRanges(error);
  const auto off = [&](double bound) { return random.Uniform(-bound, bound); };
  const auto disturb = [&](RigidInertia& body, double length) {
    const double mass_factor = 1 + off(error.mass_ratio);
    body.mass *= mass_factor;
    body.inertia *= mass_factor * (1 + off(error.inertia_ratio));
    for (int axis = 0; axis < 3; ++axis) body.com[axis] += length * off(error.com_ratio);
  };
  disturb(robot.trunk, TrunkLength(robot));
  for (LegDescription& leg : robot.legs) {
    for (std::size_t i = 0; i < leg.bodies.size(); ++i) {
      Eigen::Vector3d& end = i + 1 < leg.joints.size() ? leg.joints[i + 1].p_PJ : leg.foot_J;
      disturb(leg.bodies[i], end.norm());
      end *= 1 + off(error.length_ratio);
    }
  }
  return robot;
}

}  // namespace tenon
