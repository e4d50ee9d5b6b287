#pragma once

#include <tenon/plants/signals/leg.h>
#include <tenon/plants/signals/quaternion.h>

namespace tenon {

/// @file
/// Signals of a quadruped. W is the world, z up; B is fixed to the trunk, x forward, y left.
/// Joints and legs in the order of leg.h. SI units.

/// Pose and velocity of the trunk, joint angles and speeds.
struct LeggedState {
  Vec<3> p_WB = Vec<3>::Zero();  ///< B's origin [m]
  Vec<4> q_WB{1, 0, 0, 0};       ///< attitude, (w, x, y, z)
  Vec<12> q = Vec<12>::Zero();   ///< joint angles [rad]
  Vec<3> v_W = Vec<3>::Zero();   ///< velocity of B's origin [m/s]
  Vec<3> w_W = Vec<3>::Zero();   ///< angular velocity of B [rad/s]
  Vec<12> qd = Vec<12>::Zero();  ///< joint speeds [rad/s]

  Eigen::Matrix3d R_WB() const { return RotationFromQuaternion(q_WB); }
  static FieldList Fields() {
    return {{"p_WB", &LeggedState::p_WB, "m"},
            {"q_WB", &LeggedState::q_WB, "", "w,x,y,z"},
            {"q", &LeggedState::q, "rad", kJointElements},
            {"v_W", &LeggedState::v_W, "m/s"},
            {"w_W", &LeggedState::w_W, "rad/s"},
            {"qd", &LeggedState::qd, "rad/s", kJointElements}};
  }
};

/// The rates of LeggedState's velocities: nu' with nu = (v_W, w_W, qd).
struct LeggedAcceleration {
  Vec<3> a_W = Vec<3>::Zero();      ///< acceleration of B's origin [m/s^2]
  Vec<3> alpha_W = Vec<3>::Zero();  ///< angular, of B [rad/s^2]
  Vec<12> qdd = Vec<12>::Zero();    ///< accelerations of the joints [rad/s^2]

  static FieldList Fields() {
    return {{"a_W", &LeggedAcceleration::a_W, "m/s^2"},
            {"alpha_W", &LeggedAcceleration::alpha_W, "rad/s^2"},
            {"qdd", &LeggedAcceleration::qdd, "rad/s^2", kJointElements}};
  }
};

/// Measured joint angles and speeds.
struct JointMotion {
  Vec<12> q = Vec<12>::Zero();   ///< [rad]
  Vec<12> qd = Vec<12>::Zero();  ///< [rad/s]

  static FieldList Fields() {
    return {{"q", &JointMotion::q, "rad", kJointElements}, {"qd", &JointMotion::qd, "rad/s", kJointElements}};
  }
};

/// Ground force on each foot [N].
struct FootForces {
  Vec<3> front_left = Vec<3>::Zero();
  Vec<3> front_right = Vec<3>::Zero();
  Vec<3> rear_left = Vec<3>::Zero();
  Vec<3> rear_right = Vec<3>::Zero();

  Vec<3>& operator[](int leg) { return this->*kMembers[leg]; }
  const Vec<3>& operator[](int leg) const { return this->*kMembers[leg]; }
  static FieldList Fields() {
    return {{"front_left", &FootForces::front_left, "N"},
            {"front_right", &FootForces::front_right, "N"},
            {"rear_left", &FootForces::rear_left, "N"},
            {"rear_right", &FootForces::rear_right, "N"}};
  }

 private:
  static const std::array<Vec<3> FootForces::*, kNumLegs> kMembers;
};
inline constexpr std::array<Vec<3> FootForces::*, kNumLegs> FootForces::kMembers{
    &FootForces::front_left, &FootForces::front_right, &FootForces::rear_left, &FootForces::rear_right};

/// Joints held by a spring and a damper in parallel to their drive: torque -stiffness (q - angle) - damping
/// qd. Joints with stiffness 0 are free.
struct JointLocks {
  Vec<12> angle = Vec<12>::Zero();      ///< [rad]
  Vec<12> stiffness = Vec<12>::Zero();  ///< [N m/rad]
  Vec<12> damping = Vec<12>::Zero();    ///< [N m s/rad]

  static FieldList Fields() {
    return {{"angle", &JointLocks::angle, "rad", kJointElements},
            {"stiffness", &JointLocks::stiffness, "N m/rad", kJointElements},
            {"damping", &JointLocks::damping, "N m s/rad", kJointElements}};
  }
};

/// Force on a point of the robot, and torque.
struct ExternalForce {
  int body = 0;                      ///< 0 the trunk, 1 + j the body that joint j moves
  Vec<3> p_B = Vec<3>::Zero();       ///< point of application, in that body's frame [m]
  Vec<3> force_W = Vec<3>::Zero();   ///< [N]
  Vec<3> torque_W = Vec<3>::Zero();  ///< [N m]

  static FieldList Fields() {
    return {{"body", &ExternalForce::body},
            {"p_B", &ExternalForce::p_B, "m"},
            {"force_W", &ExternalForce::force_W, "N"},
            {"torque_W", &ExternalForce::torque_W, "N m"}};
  }
};

inline constexpr int kMaxExternalForces = 8;
/// Default entries are zero forces.
using ExternalForces = std::array<ExternalForce, kMaxExternalForces>;

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::LeggedState);
TENON_DECLARE_SIGNAL(tenon::LeggedAcceleration);
TENON_DECLARE_SIGNAL(tenon::JointMotion);
TENON_DECLARE_SIGNAL(tenon::FootForces);
TENON_DECLARE_SIGNAL(tenon::JointLocks);
TENON_DECLARE_SIGNAL(tenon::ExternalForce);
TENON_DECLARE_SIGNAL(tenon::ExternalForces);
