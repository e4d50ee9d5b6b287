#include <tenon/plants/model/vectors.h>

#include <algorithm>
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

double SegmentDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& u, const Eigen::Vector3d& q,
                       const Eigen::Vector3d& v, Eigen::Vector2d* at) {
  // The nearest points are p + s u and q + t v: both inside their segments, or at least one at an end.
  const Eigen::Vector3d w = p - q;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  const auto clamp = [](double x) { return std::clamp(x, 0.0, 1.0); };
  const double s = determinant > 1e-14 * uu * vv ? clamp((uv * vw - vv * uw) / determinant) : 0;
  const double t = vv > 0 ? clamp((uv * s + vw) / vv) : 0;
  const double s_of_t = uu > 0 ? clamp((uv * t - uw) / uu) : 0;
  if (at != nullptr) *at << s_of_t, t;
  return (w + s_of_t * u - t * v).norm();
}

double SegmentBoxDistance(const Eigen::Vector3d& p, const Eigen::Vector3d& u, const Eigen::Vector3d& half,
                          double* at) {
  // The distance is convex along the segment, so bisection on the sign of its slope finds the minimum.
  const auto beyond = [&](double s) -> Eigen::Vector3d {
    const Eigen::Vector3d x = p + s * u;
    return x - x.cwiseMax(-half).cwiseMin(half);
  };
  double low = 0, high = beyond(0).dot(u) >= 0 ? 0 : 1;
  for (int i = high > 0 && beyond(1).dot(u) > 0 ? 30 : 0; i > 0; --i) {
    const double middle = (low + high) / 2;
    (beyond(middle).dot(u) < 0 ? low : high) = middle;
  }
  if (at != nullptr) *at = high;
  return beyond(high).norm();  // 0 inside the box
}

}  // namespace tenon
