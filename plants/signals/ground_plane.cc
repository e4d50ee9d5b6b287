#include <tenon/plants/signals/euler.h>
#include <tenon/plants/signals/ground_plane.h>

#include <Eigen/Geometry>

namespace tenon {
namespace {

Eigen::Vector2d InHeading(const Eigen::Vector2d& v, double yaw) {
  return Eigen::Rotation2Dd(-yaw) * v;
}

}  // namespace

double GroundPlane::HeightAt(const Eigen::Vector2d& place) const {
  return p_W[2] + slope.dot(place - p_W.head<2>());
}

Vec<3> GroundPlane::Normal() const {
  return Vec<3>(-slope[0], -slope[1], 1).normalized();
}

Eigen::Vector3d EulerOnSlope(const Eigen::Vector2d& slope, double yaw) {
  const Eigen::Vector2d s = InHeading(slope, yaw);
  return {std::asin(s[1] / std::sqrt(1 + s.squaredNorm())), -std::atan(s[0]), yaw};
}

Eigen::Vector3d EulerRateOnSlope(const Eigen::Vector2d& slope, const Eigen::Vector2d& slope_rate, double yaw,
                                 double yaw_rate) {
  const Eigen::Vector2d s = InHeading(slope, yaw);
  const Eigen::Vector2d rate = InHeading(slope_rate, yaw) + yaw_rate * Eigen::Vector2d(s[1], -s[0]);
  const double forward = 1 + s[0] * s[0], square = 1 + s.squaredNorm();
  // Rate of sin(roll), divided by cos(roll) = sqrt(forward / square).
  const double roll_rate = (rate[1] - s[1] * s.dot(rate) / square) / std::sqrt(forward);
  return {roll_rate, -rate[0] / forward, yaw_rate};
}

Eigen::Matrix2d FootprintOnSlope(const Eigen::Vector2d& slope, double yaw) {
  return RotationFromEuler(EulerOnSlope(slope, yaw)).topLeftCorner<2, 2>();
}

}  // namespace tenon
