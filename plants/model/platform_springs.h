#pragma once

#include <tenon/plants/model/cdpr_description.h>

namespace tenon {

/// The wrench of springs between frame and platform about the platform's CoM at p_WB, force before torque, in
/// W [N, N m]. With b = p_WB + R_WB r the attachment and a the anchor, each one pulls with
///
///     F = k (1 - l0 / l) (a - b),   l = |a - b|,   torque R_WB r x F,
///
/// and pushes where it is shorter than l0. It is minus the gradient of CalcSpringEnergy(). `jacobian`
/// receives its derivative with respect to p_WB and to a rotation vector in W, R_WB -> exp([theta]x) R_WB.
/// Does not allocate.
/// @throws RunError if a spring with a rest length has length 0, and therefore no direction.
Eigen::Matrix<double, 6, 1> CalcSpringWrench(const std::vector<SpringDescription>& springs,
                                             const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                                             Eigen::Matrix<double, 6, 6>* jacobian = nullptr);

/// The energy of the springs, the sum of k (l - l0)^2 / 2 [J].
double CalcSpringEnergy(const std::vector<SpringDescription>& springs, const Eigen::Vector3d& p_WB,
                        const Eigen::Matrix3d& R_WB);

}  // namespace tenon
