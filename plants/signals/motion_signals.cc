#include <tenon/plants/signals/motion_signals.h>

#include <Eigen/Geometry>

namespace tenon {

Eigen::Matrix2d PlanarPath::Heading() const {
  return Eigen::Rotation2Dd(yaw).toRotationMatrix();
}

// The velocity in W at time s is R(yaw + yaw_rate s) velocity; its integral from 0 to t is t R(yaw) S
// velocity with S = [a -b; b a], a = sin(angle) / angle, b = (1 - cos(angle)) / angle, angle = yaw_rate t.
PlanarPath PlanarPath::At(double t) const {
  const double angle = yaw_rate * t;
  const double a = angle == 0 ? 1 : std::sin(angle) / angle;
  const double b = angle == 0 ? 0 : std::sin(angle / 2) * std::sin(angle / 2) / (angle / 2);
  PlanarPath next = *this;
  next.position_W +=
      t * (Heading() * Eigen::Vector2d(a * velocity[0] - b * velocity[1], b * velocity[0] + a * velocity[1]));
  next.yaw += angle;
  return next;
}

}  // namespace tenon
