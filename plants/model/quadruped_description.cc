#include <tenon/plants/model/quadruped_description.h>
#include <tenon/systems/framework/types/errors.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tenon {
namespace {

void CheckPositive(const char* key, double value, const char* remedy) {
  if (!(value > 0))
    throw ParameterError(fmt::format("{} is {} but must be positive; {}", key, value, remedy));
}

void CheckNotNegative(const char* key, double value) {
  if (!(value >= 0))
    throw ParameterError(
        fmt::format("{} is {} but must not be negative; give 0 for none, or a positive value", key, value));
}

/// A point of the leg's body i, given in that body's frame, in the trunk's frame B.
Eigen::Vector3d PointInTrunk(const LegDescription& leg, int i, Eigen::Vector3d p,
                             const Vec<kJointsPerLeg>& q) {
  for (; i >= 0; --i) {
    const JointDescription& joint = leg.joints[static_cast<std::size_t>(i)];
    p = joint.p_PJ + Eigen::AngleAxisd(q[i], joint.axis) * p;
  }
  return p;
}

}  // namespace

void DriveProperties::Validate() const {
  CheckNotNegative("rotor_inertia_kg_m2", rotor_inertia);
  CheckNotNegative("damping_N_m_s_per_rad", damping);
  constexpr double kMostDamping = 1e4;  // N m s/rad; with a leg's inertia a time constant of microseconds
  if (damping > kMostDamping)
    throw ParameterError(fmt::format(
        "damping_N_m_s_per_rad is {} but must be at most {}: with a higher value, the joint hardly moves",
        damping, kMostDamping));
  CheckNotNegative("friction_N_m", friction);
  if (!(full_torque_speed_ratio >= 0 && full_torque_speed_ratio < 1))
    throw ParameterError(
        fmt::format("full_torque_speed_ratio is {} but must be at least 0 and below 1; it is the part of the "
                    "speed limit up "
                    "to which the motor has its full torque",
                    full_torque_speed_ratio));
  CheckNotNegative("stop_stiffness_N_m_per_rad", stop_stiffness);
  CheckNotNegative("stop_dissipation_s_per_rad", stop_dissipation);
}

void ContactProperties::Validate() const {
  CheckPositive("stiffness_N_per_m", stiffness, "give the weight on a foot over its static depth");
  CheckNotNegative("dissipation_s_per_m", dissipation);
  CheckPositive("blend_m", blend, "give about a tenth of the static depth");
  CheckPositive("bristle_stiffness_per_m", bristle_stiffness,
                "give the friction coefficient over the deflection before sliding");
  CheckNotNegative("bristle_damping_s_per_m", bristle_damping);
  CheckPositive("bristle_friction", bristle_friction, "give 0.2, or the lowest friction of interest");
  CheckPositive("full_friction_N", full_friction, "give a small fraction of the weight on a foot");
  CheckPositive("release_time_s", release_time, "give a few milliseconds");
}

double QuadrupedDescription::mass() const {
  double sum = trunk.mass;
  for (const LegDescription& leg : legs)
    for (const RigidInertia& body : leg.bodies) sum += body.mass;
  return sum;
}

Eigen::Vector3d QuadrupedDescription::HipPosition(int leg, const Vec<kNumJoints>& q) const {
  const LegDescription& at = legs[static_cast<std::size_t>(leg)];
  return PointInTrunk(at, 0, at.joints[1].p_PJ, q.segment<kJointsPerLeg>(kJointsPerLeg * leg));
}

double QuadrupedDescription::LegLength(int leg) const {
  const LegDescription& at = legs[static_cast<std::size_t>(leg)];
  return at.joints[2].p_PJ.norm() + at.foot_J.norm();
}

Eigen::Vector3d QuadrupedDescription::FootPosition(int leg, const Vec<kNumJoints>& q) const {
  const LegDescription& at = legs[static_cast<std::size_t>(leg)];
  return PointInTrunk(at, kJointsPerLeg - 1, at.foot_J, q.segment<kJointsPerLeg>(kJointsPerLeg * leg));
}

LegPose QuadrupedDescription::PoseOfLeg(int leg, const Vec<kNumJoints>& q) const {
  const LegDescription& at = legs[static_cast<std::size_t>(leg)];
  LegPose pose;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
    const JointDescription& joint = at.joints[i];
    p += R * joint.p_PJ;
    R = R * Eigen::AngleAxisd(q[kJointsPerLeg * leg + static_cast<int>(i)], joint.axis);
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

}  // namespace tenon
