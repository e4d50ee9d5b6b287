#include <tenon/controllers/legged/planning/planar_spline.h>

namespace tenon {

PlanarPoint PlanarSpline::At(double t) const {
  PlanarPoint point;
  point.position = origin;
  if (num_segments == 0) return point;
  std::size_t k = 0;
  while (k + 1 < static_cast<std::size_t>(num_segments) && t >= segments[k].duration) {
    t -= segments[k++].duration;
  }
  // Horner's scheme for the polynomial and its two derivatives in s = t / T.
  const auto& c = segments[k].coefficients;
  const double T = segments[k].duration, s = t / T;
  Eigen::Vector2d p = c[5], v = Eigen::Vector2d::Zero(), half_a = Eigen::Vector2d::Zero();
  for (std::size_t i = 5; i-- > 0;) {
    half_a = half_a * s + v;
    v = v * s + p;
    p = p * s + c[i];
  }
  point.position += p;
  point.velocity = v / T;
  point.acceleration = 2 * half_a / (T * T);
  return point;
}

}  // namespace tenon
