#pragma once

#include <tenon/systems/framework/fields.h>
#include <tenon/systems/framework/signal.h>

#include <Eigen/Core>
#include <array>
#include <string>
#include <utility>
#include <vector>

namespace tenon {

inline constexpr int kMinCables = 4;

/// One value per cable, of which there are as many as the description says. Assigning to a vector of the same
/// size does not allocate.
using CableVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign>;

/// The straight cable between a platform attachment and an anchor.
struct CableDescription {
  Eigen::Vector3d anchor_W = Eigen::Vector3d::Zero();  ///< anchor point in the world [m]
  Eigen::Vector3d attachment_B =
      Eigen::Vector3d::Zero();  ///< attachment, from the CoM, in the platform frame [m]

  static FieldList Fields() {
    return {Required("anchor_m", &CableDescription::anchor_W),
            Required("attachment_m", &CableDescription::attachment_B)};
  }
};

/// What a cable is made of and what it may carry; the same for all cables of a robot.
struct CableProperties {
  double axial_stiffness = 0;  ///< EA [N]; the stiffness of a cable of rest length l0 is EA / l0
  double axial_damping = 0;    ///< EA times the material's damping time [N s]; damping is this over l0
  double tension_min = 0;      ///< lower bound of the commanded tension [N]
  double tension_max = 0;      ///< upper bound of the commanded tension [N]

  static FieldList Fields() {
    return {Required("axial_stiffness_N", &CableProperties::axial_stiffness),
            Required("axial_damping_N_s", &CableProperties::axial_damping),
            Required("tension_min_N", &CableProperties::tension_min),
            Required("tension_max_N", &CableProperties::tension_max)};
  }
  void Validate() const;  ///< throws ParameterError
};

enum class WinchMode {
  kTension,  ///< the winch's own controller tracks the commanded tension
  kTorque,   ///< the command is the motor's torque, given as tension at the drum
};

constexpr auto EnumNames(WinchMode) {
  return std::array{Named{WinchMode::kTension, "tension"}, Named{WinchMode::kTorque, "torque"}};
}

/// The winch of a cable, reduced to the drum.
struct WinchProperties {
  WinchMode mode = WinchMode::kTension;
  double time_constant = 0;  ///< first-order lag from the command to the motor [s]
  double reel_damping =
      0;  ///< tension error per reeling speed in tension mode, friction in torque mode [N s/m]
  double effective_mass =
      0;  ///< rotor inertia over drum radius squared, gear included [kg]; torque mode only

  static FieldList Fields() {
    return {{"mode", &WinchProperties::mode},
            Required("time_constant_s", &WinchProperties::time_constant),
            Required("reel_damping_N_s_per_m", &WinchProperties::reel_damping),
            {"effective_mass_kg", &WinchProperties::effective_mass}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A cable-driven parallel robot: one rigid platform, 4 or more straight cables, one winch each.
///
/// Frames: W is the world, z up; B has its origin at the platform's CoM, so that a file gives attachments
/// from there. The file's keys are those of Fields(); the inertia is a list of three rows or of the diagonal
/// alone.
struct CdprDescription {
  std::string name;
  double mass = 0;                                      ///< [kg]
  Eigen::Matrix3d inertia_B = Eigen::Matrix3d::Zero();  ///< about the CoM, in B [kg m^2]
  std::vector<CableDescription> cables;
  CableProperties cable;
  WinchProperties winch;

  int num_cables() const { return static_cast<int>(cables.size()); }

  static FieldList Fields() {
    return {Required("name", &CdprDescription::name),
            Required("mass_kg", &CdprDescription::mass),
            Required("inertia_kg_m2", &CdprDescription::inertia_B),
            Required("cables", &CdprDescription::cables),
            Required("cable_properties", &CdprDescription::cable),
            Required("winch", &CdprDescription::winch)};
  }
  /// Throws ParameterError for what no robot can have: a mass that is not positive, an inertia that no rigid
  /// body has, too few cables, two cables in one place, and what the parts refuse.
  void Validate() const;
};

/// Reads a robot from a YAML file, such as plants/robots/cdpr_4.yaml. Throws ParameterError.
CdprDescription LoadCdpr(const std::string& path);

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::CableVector);
