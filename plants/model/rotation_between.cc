#include <tenon/plants/model/rotation_between.h>

#include <cmath>

namespace tenon {

// Eigen's FromTwoVectors decomposes a matrix for opposite directions, which takes a compiler ten seconds.
Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = b.dot(a);
  constexpr double kOpposite = -1 + 1e-12;
  if (cosine < kOpposite) return Eigen::Quaterniond(Eigen::AngleAxisd(std::acos(-1.0), a.unitOrthogonal()));
  const double twice_w = std::sqrt((1 + cosine) * 2);
  const Eigen::Vector3d v = a.cross(b) * (1 / twice_w);
  return {twice_w * 0.5, v.x(), v.y(), v.z()};
}

}  // namespace tenon
