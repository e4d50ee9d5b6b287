#pragma once

#include <Eigen/Core>

namespace tenon {

/// The vector with its length limited to `longest`.
template <int n>
Eigen::Matrix<double, n, 1> Shortened(const Eigen::Matrix<double, n, 1>& v, double longest) {
  const double length = v.norm();
  if (length <= longest) return v;
  return v * (longest / length);
}

}  // namespace tenon
