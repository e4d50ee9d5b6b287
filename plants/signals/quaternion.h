#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// @file
/// Unit quaternions (w, x, y, z) of signals. q_WB transforms components in B to components in W; q and -q are
/// equivalent.

/// Rotation matrix of a quaternion of any non-zero length.
Eigen::Matrix3d RotationFromQuaternion(const Vec<4>& q);

/// One of the two unit quaternions of a rotation matrix.
Vec<4> QuaternionFromRotation(const Eigen::Matrix3d& R);

/// Quaternion of the rotation by |v| [rad] about v.
Vec<4> QuaternionFromRotationVector(const Eigen::Vector3d& v);

/// Quaternion of ZYX Euler angles, see euler.h; continuous in the angles.
Vec<4> QuaternionFromEuler(const Eigen::Vector3d& euler);

/// Product with R(a b) = R(a) R(b).
Vec<4> QuaternionProduct(const Vec<4>& a, const Vec<4>& b);

/// dq/dt = (0, w) q / 2 of a body with the angular velocity `w_W` [rad/s]; |q| is constant.
Vec<4> QuaternionRate(const Vec<4>& q_WB, const Vec<3>& w_W);

}  // namespace tenon
