#include <tenon/plants/signals/euler.h>

#include <cmath>
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

}  // namespace tenon
