#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <Eigen/Core>

namespace tenon {

/// @file
/// Unit quaternions (w, x, y, z) as signals carry them. q_WB takes components in B to components in W; q and
/// -q are the same attitude.

/// The rotation of a quaternion of any length but zero.
Eigen::Matrix3d RotationFromQuaternion(const Vec<4>& q);

/// One of the two unit quaternions of a rotation.
Vec<4> QuaternionFromRotation(const Eigen::Matrix3d& R);

/// The rotation by |v| [rad] about v.
Vec<4> QuaternionFromRotationVector(const Eigen::Vector3d& v);

/// The rotation of ZYX Euler angles, see euler.h; continuous in them.
Vec<4> QuaternionFromEuler(const Eigen::Vector3d& euler);

/// First b, then a: R(a b) = R(a) R(b).
Vec<4> QuaternionProduct(const Vec<4>& a, const Vec<4>& b);

/// dq/dt = (0, w) q / 2 for a body that turns with the angular velocity `w_W` [rad/s]; leaves |q| as it is.
Vec<4> QuaternionRate(const Vec<4>& q_WB, const Vec<3>& w_W);

}  // namespace tenon
