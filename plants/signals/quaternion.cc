#include <tenon/plants/signals/quaternion.h>

#include <Eigen/Geometry>

namespace tenon {

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

}  // namespace tenon
