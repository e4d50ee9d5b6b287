#pragma once

#include <Eigen/Core>

namespace tenon {

/// @file
/// ZYX Euler angles, Theta = (roll, pitch, yaw) [rad]: R_WB = Rz(yaw) Ry(pitch) Rx(roll).
///
/// They are used at ports for display and in the state of Morlando 2023, eq. (3.5); all other code uses R_WB.
/// The axes of roll and yaw coincide at pitch = +-pi/2, where EulerRateMatrix() is singular.

/// The rotation R_WB that takes components in B to components in W.
Eigen::Matrix3d RotationFromEuler(const Eigen::Vector3d& euler);

/// The angles of a rotation: roll and yaw in (-pi, pi], pitch in [-pi/2, pi/2].
Eigen::Vector3d EulerFromRotation(const Eigen::Matrix3d& R_WB);

/// Equivalent angles that differ from `near` by at most half a turn each.
Eigen::Vector3d EulerNear(const Eigen::Vector3d& euler, const Eigen::Vector3d& near);

/// E(Theta) with w_W = E(Theta) dTheta/dt: the axes of roll, pitch and yaw in W, as columns.
Eigen::Matrix3d EulerRateMatrix(const Eigen::Vector3d& euler);

}  // namespace tenon
