#pragma once

#include <tenon/plants/signals/cable_vector.h>
#include <tenon/plants/signals/quaternion.h>

namespace tenon {

/// @file
/// Signals of a cable-driven parallel robot. W is the world, z up; B is fixed to the platform
/// with its origin at the platform's CoM. SI units.

/// Pose and velocity of the platform.
struct PlatformState {
  Vec<3> p_WB = Vec<3>::Zero();  ///< CoM [m]
  Vec<4> q_WB{1, 0, 0, 0};       ///< attitude, (w, x, y, z)
  Vec<3> v_W = Vec<3>::Zero();   ///< velocity of the CoM [m/s]
  Vec<3> w_W = Vec<3>::Zero();   ///< angular velocity [rad/s]

  Eigen::Matrix3d R_WB() const { return RotationFromQuaternion(q_WB); }
  static FieldList Fields() {
    return {{"p_WB", &PlatformState::p_WB, "m"},
            {"q_WB", &PlatformState::q_WB, "", "w,x,y,z"},
            {"v_W", &PlatformState::v_W, "m/s"},
            {"w_W", &PlatformState::w_W, "rad/s"}};
  }
};

/// Acceleration of the platform.
struct PlatformAcceleration {
  Vec<3> a_W = Vec<3>::Zero();      ///< acceleration of the CoM [m/s^2]
  Vec<3> alpha_W = Vec<3>::Zero();  ///< angular [rad/s^2]

  static FieldList Fields() {
    return {{"a_W", &PlatformAcceleration::a_W, "m/s^2"},
            {"alpha_W", &PlatformAcceleration::alpha_W, "rad/s^2"}};
  }
};

/// Force and torque on the platform, about its CoM.
struct PlatformWrench {
  Vec<3> force_W = Vec<3>::Zero();   ///< [N]
  Vec<3> torque_W = Vec<3>::Zero();  ///< [N m]

  static FieldList Fields() {
    return {{"force_W", &PlatformWrench::force_W, "N"}, {"torque_W", &PlatformWrench::torque_W, "N m"}};
  }
};

/// A point mass fixed to the platform; none if the mass is 0.
struct Payload {
  double mass = 0;              ///< mass of the payload [kg]
  Vec<3> p_B = Vec<3>::Zero();  ///< position from the CoM of the empty platform [m]

  static FieldList Fields() { return {{"mass", &Payload::mass, "kg"}, {"p_B", &Payload::p_B, "m"}}; }
};

/// Estimated load of a platform: a point mass, and the remaining external wrench.
struct LoadEstimate {
  Payload payload;
  PlatformWrench rest;

  /// True if there is a load.
  bool any() const { return payload.mass != 0 || !rest.force_W.isZero(0) || !rest.torque_W.isZero(0); }
  static FieldList Fields() { return {{"payload", &LoadEstimate::payload}, {"rest", &LoadEstimate::rest}}; }
};

/// Cables as measured by ideal winches, one entry each.
struct CableSignals {
  CableVector length;       ///< along the cable from attachment to anchor, under strain [m]
  CableVector length_rate;  ///< how fast the attachment draws cable [m/s]
  CableVector tension;      ///< at the anchor, not negative; 0 if slack without weight [N]
  CableVector rest_length;  ///< unstrained length paid out by the winch [m]

  static CableSignals Zero(int num_cables) {
    const CableVector zero = CableVector::Zero(num_cables);
    return {zero, zero, zero, zero};
  }
  static FieldList Fields() {
    return {{"length", &CableSignals::length, "m"},
            {"length_rate", &CableSignals::length_rate, "m/s"},
            {"tension", &CableSignals::tension, "N"},
            {"rest_length", &CableSignals::rest_length, "m"}};
  }
};

/// Faults of the cables and their winches, one entry each: 1 if faulty, else 0. Empty vectors mean no faults.
struct CableFaults {
  CableVector stuck;   ///< the winch's drum does not turn
  CableVector broken;  ///< the cable has no tension, and its drum does not turn

  bool is_stuck(Eigen::Index cable) const { return Holds(stuck, cable) || is_broken(cable); }
  bool is_broken(Eigen::Index cable) const { return Holds(broken, cable); }
  static FieldList Fields() { return {{"stuck", &CableFaults::stuck}, {"broken", &CableFaults::broken}}; }

 private:
  static bool Holds(const CableVector& faults, Eigen::Index cable) {
    return cable < faults.size() && faults[cable] != 0;
  }
};

/// Pose of the platform measured by a motion capture system.
struct PoseMeasurement {
  Vec<3> p_WB = Vec<3>::Zero();  ///< CoM [m]
  Vec<4> q_WB{1, 0, 0, 0};       ///< attitude, (w, x, y, z)

  Eigen::Matrix3d R_WB() const { return RotationFromQuaternion(q_WB); }
  static FieldList Fields() {
    return {{"p_WB", &PoseMeasurement::p_WB, "m"}, {"q_WB", &PoseMeasurement::q_WB, "", "w,x,y,z"}};
  }
};

/// Mechanical energy of platform, payload and cables [J]; the potential is that of gravity, 0 at z = 0.
struct CdprEnergy {
  double kinetic = 0;
  double potential = 0;
  double elastic = 0;

  double total() const { return kinetic + potential + elastic; }
  static FieldList Fields() {
    return {{"kinetic", &CdprEnergy::kinetic, "J"},
            {"potential", &CdprEnergy::potential, "J"},
            {"elastic", &CdprEnergy::elastic, "J"}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::PlatformState);
TENON_DECLARE_SIGNAL(tenon::PlatformAcceleration);
TENON_DECLARE_SIGNAL(tenon::PlatformWrench);
TENON_DECLARE_SIGNAL(tenon::CableSignals);
TENON_DECLARE_SIGNAL(tenon::CableFaults);
TENON_DECLARE_SIGNAL(tenon::CdprEnergy);
TENON_DECLARE_SIGNAL(tenon::PoseMeasurement);
TENON_DECLARE_SIGNAL(tenon::Payload);
TENON_DECLARE_SIGNAL(tenon::LoadEstimate);
