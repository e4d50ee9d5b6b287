#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/model/vectors.h>

#include <fmt/core.h>

namespace tenon {

Eigen::Matrix<double, 6, 1> CalcSpringWrench(const std::vector<SpringDescription>& springs,
                                             const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                                             Eigen::Matrix<double, 6, 6>* jacobian) {
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
  if (jacobian) jacobian->setZero();
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const auto& [anchor_W, attachment_B, k, rest_length] = springs[i];
    const Eigen::Vector3d arm = R_WB * attachment_B, span = anchor_W - p_WB - arm;
    const double length = span.norm();
    if (length == 0 && rest_length > 0)
      throw RunError(fmt::format(
          "springs.{} has no direction: its attachment is at its anchor ({:.4g}, {:.4g}, {:.4g}) m; keep the "
          "platform away from it, or give rest_length_m 0",
          i, anchor_W.x(), anchor_W.y(), anchor_W.z()));
    const double compression = rest_length > 0 ? k * rest_length / length : 0;  // k l0 / l
    const Eigen::Vector3d force = (k - compression) * span;
    wrench.head<3>() += force;
    wrench.tail<3>() += arm.cross(force);
    if (!jacobian) continue;
    // If the attachment moves by d, the force changes by -stiffness d.
    Eigen::Matrix3d stiffness = (k - compression) * Eigen::Matrix3d::Identity();
    if (compression > 0) stiffness += compression / (length * length) * span * span.transpose();
    const Eigen::Matrix3d cross = CrossMatrix(arm), by_turn = stiffness * cross;
    jacobian->topLeftCorner<3, 3>() -= stiffness;
    jacobian->bottomLeftCorner<3, 3>() -= cross * stiffness;
    jacobian->topRightCorner<3, 3>() += by_turn;
    jacobian->bottomRightCorner<3, 3>() += cross * by_turn + CrossMatrix(force) * cross;
  }
  return wrench;
}

double CalcSpringEnergy(const std::vector<SpringDescription>& springs, const Eigen::Vector3d& p_WB,
                        const Eigen::Matrix3d& R_WB) {
  double energy = 0;
  for (const SpringDescription& spring : springs)
    energy += spring.stiffness / 2 *
              std::pow((spring.anchor_W - p_WB - R_WB * spring.attachment_B).norm() - spring.rest_length, 2);
  return energy;
}

}  // namespace tenon
