#include <tenon/plants/signals/euler.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/quaternion.h>

#include <Eigen/Geometry>

#include <numbers>

namespace tenon {

Eigen::Matrix3d RotationFromEuler(const Eigen::Vector3d& euler) {
  const double sr = std::sin(euler[0]), cr = std::cos(euler[0]);
  const double sp = std::sin(euler[1]), cp = std::cos(euler[1]);
  const double sy = std::sin(euler[2]), cy = std::cos(euler[2]);
  Eigen::Matrix3d R_WB;
  R_WB << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,      //
      -sp, cp * sr, cp * cr;
  return R_WB;
}

Eigen::Vector3d EulerFromRotation(const Eigen::Matrix3d& R_WB) {
  return {std::atan2(R_WB(2, 1), R_WB(2, 2)), std::atan2(-R_WB(2, 0), std::hypot(R_WB(0, 0), R_WB(1, 0))),
          std::atan2(R_WB(1, 0), R_WB(0, 0))};
}

Eigen::Vector3d EulerNear(const Eigen::Vector3d& euler, const Eigen::Vector3d& near) {
  constexpr double kTurn = 2 * std::numbers::pi;
  Eigen::Vector3d result;
  for (int i = 0; i < 3; ++i) result[i] = euler[i] - kTurn * std::round((euler[i] - near[i]) / kTurn);
  return result;
}

Eigen::Matrix3d EulerRateMatrix(const Eigen::Vector3d& euler) {
  const double sp = std::sin(euler[1]), cp = std::cos(euler[1]);
  const double sy = std::sin(euler[2]), cy = std::cos(euler[2]);
  Eigen::Matrix3d E;
  E << cy * cp, -sy, 0,  //
      sy * cp, cy, 0,    //
      -sp, 0, 1;
  return E;
}

Eigen::Matrix3d RotationFromQuaternion(const Vec<4>& q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

Vec<4> QuaternionFromRotation(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return {q.w(), q.x(), q.y(), q.z()};
}

Vec<4> QuaternionFromRotationVector(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const double scale = angle < 1e-8 ? 0.5 : std::sin(angle / 2) / angle;
  return {std::cos(angle / 2), scale * v[0], scale * v[1], scale * v[2]};
}

Vec<4> QuaternionFromEuler(const Eigen::Vector3d& euler) {
  const auto turn = [](double angle, int axis) {
    Vec<4> q = Vec<4>::Zero();
    q[0] = std::cos(angle / 2);
    q[1 + axis] = std::sin(angle / 2);
    return q;
  };
  return QuaternionProduct(QuaternionProduct(turn(euler[2], 2), turn(euler[1], 1)), turn(euler[0], 0));
}

Vec<4> QuaternionProduct(const Vec<4>& a, const Vec<4>& b) {
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(a[0], a[1], a[2], a[3]) * Eigen::Quaterniond(b[0], b[1], b[2], b[3]);
  return {q.w(), q.x(), q.y(), q.z()};
}

Vec<4> QuaternionRate(const Vec<4>& q_WB, const Vec<3>& w_W) {
  return QuaternionProduct({0, w_W[0] / 2, w_W[1] / 2, w_W[2] / 2}, q_WB);
}

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
