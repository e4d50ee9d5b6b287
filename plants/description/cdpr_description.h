#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace tenon {

inline constexpr int kMinCables = 4;
inline constexpr int kMaxCables = 8;

/// One value per cable, 4 to 8 of them; the storage is inside the object, so copies do not allocate.
using CableVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign, kMaxCables, 1>;

/// The straight cable between a platform attachment and an anchor.
struct CableDescription {
  Eigen::Vector3d anchor_W = Eigen::Vector3d::Zero();      ///< anchor point in the world [m]
  Eigen::Vector3d attachment_B = Eigen::Vector3d::Zero();  ///< attachment, from the CoM, in the platform frame [m]
};

/// What a cable and its winch are made of; the same for all cables of a robot.
struct CableProperties {
  double axial_stiffness = 0;  ///< EA [N]; the stiffness of a cable of rest length l0 is EA / l0
  double axial_damping = 0;    ///< EA times the material's damping time [N s]; damping is this over l0
  double tension_min = 0;      ///< lower bound of the commanded tension [N]
  double tension_max = 0;      ///< upper bound of the commanded tension [N]
};

enum class WinchMode {
  kTension,  ///< the winch's own controller tracks the commanded tension
  kTorque,   ///< the command is the motor's torque, given as tension at the drum
};

/// The winch of a cable, reduced to the drum.
struct WinchProperties {
  WinchMode mode = WinchMode::kTension;
  double time_constant = 0;    ///< first-order lag from the command to the motor [s]
  double reel_damping = 0;     ///< tension error per reeling speed in tension mode, friction in torque mode [N s/m]
  double effective_mass = 0;   ///< rotor inertia over drum radius squared, gear included [kg]; torque mode only
};

/// A cable-driven parallel robot: one rigid platform, 4 to 8 straight cables, one winch each.
///
/// Frames: W is the world, z up; B has its origin at the platform's CoM. Read from YAML by LoadCdpr.
struct CdprDescription {
  std::string name;
  double mass = 0;                                        ///< [kg]
  Eigen::Matrix3d inertia_B = Eigen::Matrix3d::Zero();    ///< about the CoM, in B [kg m^2]
  std::vector<CableDescription> cables;
  CableProperties cable;
  WinchProperties winch;

  int num_cables() const { return static_cast<int>(cables.size()); }
};

}  // namespace tenon
