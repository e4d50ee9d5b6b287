#pragma once

#include <Eigen/Core>

namespace tenon {

/// The vector, or one in its direction that is `longest` if it is longer than that.
template <int n>
Eigen::Matrix<double, n, 1> Shortened(const Eigen::Matrix<double, n, 1>& v, double longest) {
  const double length = v.norm();
  if (length <= longest) return v;
  return v * (longest / length);
}

}  // namespace tenon
