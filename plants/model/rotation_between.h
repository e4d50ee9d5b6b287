#pragma once

#include <Eigen/Geometry>

namespace tenon {

/// The shortest rotation that turns the direction of `from` into that of `to`; for opposite directions, one
/// of the half turns.
Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace tenon
