#pragma once

#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/tests/controllers/optimization/qp_certificate.h>

namespace tenon::test {

/// The program of WholeBodyQp without elimination: 30 variables (nu', then f_i or gamma_k of each leg) and 18
/// equalities, written as in the header of WholeBodyQp.
inline OwnedQp FullWholeBodyQp(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                               const WholeBodyQpParams& params, const Vec<12>& torque_limit) {
  OwnedQp qp(30, 18, kNumLegs * WholeBodyQp::kRowsPerLeg);
  qp.H.setZero();
  qp.H.diagonal().head<18>().setConstant(params.acceleration_weight);
  Eigen::Matrix<double, 6, 12> G = Eigen::Matrix<double, 6, 12>::Zero();
  const Eigen::Vector3d n = task.normal_W, t_1 = FirstTangent(n), t_2 = n.cross(t_1);
  // The solver exploits zeros at the ends of equalities: feet before the trunk, and stance feet, whose
  // columns are those of nu' alone, before swing feet.
  qp.A_eq.bottomLeftCorner<6, 18>() = dynamics.M.topRows<6>();
  qp.b_eq.tail<6>() = AboutBase(dynamics, task.disturbance) - dynamics.bias().head<6>();
  int standing = 0, swinging = 3 * static_cast<int>(std::count(task.stance.begin(), task.stance.end(), true));
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    const bool stance = task.stance[i];
    const int joint = 6 + 3 * leg, column = 18 + 3 * leg, row = WholeBodyQp::kRowsPerLeg * leg;
    int& next = stance ? standing : swinging;
    const Eigen::Matrix<double, 3, 18> J = dynamics.FootJacobian(leg);
    qp.A_eq.block<3, 18>(next, 0) = J;
    qp.b_eq.segment<3>(next) = task.foot_acceleration[i] - dynamics.foot(leg).bias;
    qp.H.diagonal().segment<3>(column).setConstant(stance ? params.force_weight : params.slack_weight);
    auto torque = qp.A_in.middleRows<3>(row + 4);
    torque.leftCols<18>() = dynamics.M.middleRows<3>(joint);
    if (stance) {
      G.block<3, 3>(0, 3 * leg).setIdentity();
      G.block<3, 3>(3, 3 * leg) = CrossMatrix(dynamics.foot(leg).p_W - dynamics.com_W);
      qp.A_eq.block<6, 3>(12, column) = -J.leftCols<6>().transpose();
      torque.middleCols<3>(column) = -dynamics.foot(leg).J_leg.transpose();
      auto pyramid = qp.A_in.block<4, 3>(row, column);
      pyramid.row(0) = (params.friction * n + t_1).transpose();
      pyramid.row(1) = (params.friction * n - t_1).transpose();
      pyramid.row(2) = (params.friction * n + t_2).transpose();
      pyramid.row(3) = (params.friction * n - t_2).transpose();
    } else {
      qp.A_eq.block<3, 3>(next, column) = -Eigen::Matrix3d::Identity();
      qp.b_in.segment<4>(row).setConstant(-1);
    }
    next += 3;
    qp.A_in.middleRows<3>(row + 7) = -torque;
    const Eigen::Vector3d limit = torque_limit.segment<3>(3 * leg),
                          constant =
                              dynamics.bias().segment<3>(joint) - task.joint_disturbance.segment<3>(3 * leg);
    qp.b_in.segment<3>(row + 4) = -limit - constant;
    qp.b_in.segment<3>(row + 7) = -limit + constant;
  }
  const Eigen::Matrix<double, 6, 12> QG = params.WrenchWeights(task.tilt, task.turn).asDiagonal() * G;
  qp.H.bottomRightCorner<12, 12>() += G.transpose() * QG;
  qp.g.tail<12>() = -QG.transpose() * (task.wrench - task.disturbance);
  return qp;
}

/// Dimensions of a solver for FullWholeBodyQp.
inline DualActiveSet FullWholeBodySolver() {
  return {30, 18 + kNumLegs * WholeBodyQp::kRowsPerLeg};
}

}  // namespace tenon::test
