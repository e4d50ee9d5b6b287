#pragma once

#include <Eigen/Core>

namespace tenon {

/// Mass, centre of mass and inertia of a rigid body in some frame.
struct RigidInertia {
  double mass = 0;                                    ///< [kg]
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< position of the CoM from the frame's origin [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the CoM, in the frame's axes [kg m^2]

  /// This body expressed in a frame in which the present frame has origin p and axes R.
  RigidInertia In(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) const;
};

/// Inertia of a point mass [kg] at r [m] about the origin: mass (|r|^2 1 - r r^T), the parallel axis term.
Eigen::Matrix3d PointInertia(double mass, const Eigen::Vector3d& r);

/// Spatial inertia of a mass [kg] at r [m] with the inertia J [kg m^2], both from and about the origin;
/// angular before linear.
Eigen::Matrix<double, 6, 6> SpatialInertia(double mass, const Eigen::Vector3d& r, const Eigen::Matrix3d& J);

/// The union of two bodies given in one frame, by the parallel axis theorem.
RigidInertia operator+(const RigidInertia& a, const RigidInertia& b);

/// Throws ParameterError if no rigid body has this inertia about its CoM [kg m^2]: not finite, not symmetric,
/// not positive definite, or one principal moment above the sum of the other two.
void CheckInertia(const Eigen::Matrix3d& inertia);

inline constexpr double kGravity = 9.81;  ///< standard gravity, rounded as in Morlando 2023 [m/s^2]
/// Throws ParameterError unless `gravity` [m/s^2] is positive.
void CheckGravity(double gravity);

}  // namespace tenon
