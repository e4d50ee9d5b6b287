#pragma once

#include <Eigen/Core>

namespace tenon {

/// [a]x, with [a]x b = a x b. Always inlined, since some callers are compiled for wider vector instructions.
[[gnu::always_inline]] inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d cross;
  cross << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return cross;
}

}  // namespace tenon
