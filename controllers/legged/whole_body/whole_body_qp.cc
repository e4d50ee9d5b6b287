#include <tenon/controllers/legged/whole_body/whole_body_qp.h>

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include <tenon/plants/model/cross_matrix.h>
#include <tenon/systems/framework/system.h>

namespace tenon {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

// J_leg counts as singular if its determinant is less than this part of |J_leg|^3.
constexpr double kStraight = 1e-4;

// The trunk's columns of the foot's Jacobian.
Eigen::Matrix<double, 3, 6> TrunkJacobian(const QuadrupedDynamics& dynamics, int leg) {
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -CrossMatrix(dynamics.foot(leg).p_W - dynamics.base_W);
  return J;
}

}  // namespace

void WholeBodyQpParams::Validate() const {
  for (const auto& [name, value] :
       {std::pair{"wrench_weight", wrench_weight}, std::pair{"moment_weight", moment_weight},
        std::pair{"yaw_weight", yaw_weight}, std::pair{"force_weight", force_weight},
        std::pair{"acceleration_weight", acceleration_weight}, std::pair{"slack_weight", slack_weight},
        std::pair{"friction", friction}}) {
    Demand(value > 0, fmt::format("{} = {} must be positive", name, value));
  }
  for (const auto& [name, value] : {std::pair{"tilt_weight", tilt_weight}, std::pair{"free_tilt", free_tilt}})
    Demand(value >= 0, fmt::format("{} = {} must not be negative", name, value));
}

WholeBodyQp::Problem::Problem(int variables, int equalities)
    : H(Eigen::MatrixXd::Zero(variables, variables)),
      g(Eigen::VectorXd::Zero(variables)),
      A_eq(ConstraintMatrix::Zero(equalities, variables)),
      b_eq(Eigen::VectorXd::Zero(equalities)),
      A_in(ConstraintMatrix::Zero(kNumLegs * kRowsPerLeg, variables)),
      b_in(Eigen::VectorXd::Zero(kNumLegs * kRowsPerLeg)) {}

WholeBodyQp::WholeBodyQp(const Vec<12>& torque_limit) : torque_limit_(torque_limit) {
  Demand((torque_limit.array() > 0).all(), "the torque limits of all joints must be positive");
  map_.setZero();
  offset_.setZero();
}

QuadraticProgram WholeBodyQp::problem() const {
  const Problem& qp = eliminated_ ? reduced_ : full_;
  return {qp.H, qp.g, qp.A_eq, qp.b_eq, qp.A_in, qp.b_in};
}

Vec<3> FirstTangent(const Vec<3>& normal) {
  return (Vec<3>::UnitX() - normal[0] * normal).normalized();
}

// The cost of f and gamma, and the pyramids; both stand in three columns per leg from `first` on.
void WholeBodyQp::AddForceCost(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                               const WholeBodyQpParams& params, int first, Problem* qp) {
  Eigen::Matrix<double, 6, 12> G = Eigen::Matrix<double, 6, 12>::Zero();
  Vec<12> weight;
  const Vec<3>& n = task.normal_W;
  const Eigen::Vector3d t_1 = FirstTangent(n), t_2 = n.cross(t_1);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const bool stance = task.stance[static_cast<std::size_t>(leg)];
    const int row = kRowsPerLeg * leg, column = first + 3 * leg;
    weight.segment<3>(3 * leg).setConstant(stance ? params.force_weight : params.slack_weight);
    qp->A_in.middleRows<4>(row).setZero();
    qp->b_in.segment<4>(row).setConstant(stance ? 0 : -1);
    if (!stance) continue;
    G.block<3, 3>(0, 3 * leg).setIdentity();
    G.block<3, 3>(3, 3 * leg) = CrossMatrix(dynamics.foot(leg).p_W - dynamics.com_W);
    const double mu = params.friction;
    auto pyramid = qp->A_in.block<4, 3>(row, column);
    pyramid.row(0) = (mu * n + t_1).transpose();
    pyramid.row(1) = (mu * n - t_1).transpose();
    pyramid.row(2) = (mu * n + t_2).transpose();
    pyramid.row(3) = (mu * n - t_2).transpose();
  }
  auto H = qp->H.block<12, 12>(first, first);
  Eigen::Matrix<double, 6, 12> QG = params.wrench_weight * G;
  QG.middleRows<2>(3) = params.MomentWeight(task.tilt) * G.middleRows<2>(3);
  QG.row(5) = params.yaw_weight * G.row(5);
  H.noalias() += G.transpose() * QG;
  H.diagonal() += weight;
  qp->g.segment<12>(first).noalias() -= QG.transpose() * (task.wrench - task.disturbance);
}

// False if a leg is straight. See the header for the derivation.
bool WholeBodyQp::MakeReduced(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                              const WholeBodyQpParams& params) {
  std::array<Eigen::Matrix3d, kNumLegs> inverse;
  std::array<Eigen::Matrix<double, 3, 6>, kNumLegs> by_trunk;
  Matrix6 S = dynamics.M.topLeftCorner<6, 6>();
  Eigen::Matrix<double, 6, 13> right;  // of a_b: what each y contributes, and the rest
  right.col(12) = AboutBase(dynamics, task.disturbance) - dynamics.bias().head<6>();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    const Eigen::Matrix3d& J = dynamics.foot(leg).J_leg;
    if (!(std::abs(J.determinant()) > kStraight * std::pow(J.norm(), 3))) return false;
    inverse[i] = J.inverse();
    const auto J_b = TrunkJacobian(dynamics, leg);
    const auto M_b = dynamics.M.block<6, 3>(0, 6 + 3 * leg);
    by_trunk[i].noalias() = -inverse[i] * J_b;
    const Eigen::Vector3d a = task.foot_acceleration[i] - dynamics.foot(leg).bias;
    offset_.segment<3>(6 + 3 * leg).noalias() = inverse[i] * a;
    S.noalias() += M_b * by_trunk[i];
    right.col(12).noalias() -= M_b * offset_.segment<3>(6 + 3 * leg);
    if (task.stance[i]) {
      right.middleCols<3>(3 * leg) = J_b.transpose();
    } else {
      right.middleCols<3>(3 * leg).noalias() = -M_b * inverse[i];
    }
  }
  const Eigen::PartialPivLU<Matrix6> lu(S);
  if (!(std::abs(lu.determinant()) > 0)) return false;
  right = lu.solve(right).eval();
  offset_.head<6>() = right.col(12);
  map_.topRows<6>() = right.leftCols<12>();

  Problem& qp = reduced_;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    const int joint = 6 + 3 * leg;
    map_.middleRows<3>(joint).noalias() = by_trunk[i] * map_.topRows<6>();
    offset_.segment<3>(joint).noalias() += by_trunk[i] * offset_.head<6>();
    if (!task.stance[i]) map_.block<3, 3>(joint, 3 * leg) += inverse[i];
  }
  qp.H.noalias() = params.acceleration_weight * (map_.transpose() * map_);
  qp.g.noalias() = params.acceleration_weight * (map_.transpose() * offset_);
  AddForceCost(dynamics, task, params, 0, &qp);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    const int joint = 6 + 3 * leg, row = kRowsPerLeg * leg + 4;
    const auto M_b = dynamics.M.block<3, 6>(joint, 0);
    const auto M_q = dynamics.M.block<3, 3>(joint, joint);
    Eigen::Matrix<double, 3, 12> A;
    A.noalias() = M_b * map_.topRows<6>();
    A.noalias() += M_q * map_.middleRows<3>(joint);
    Eigen::Vector3d constant = dynamics.bias().segment<3>(joint) - task.joint_disturbance.segment<3>(3 * leg);
    constant.noalias() += M_b * offset_.head<6>();
    constant.noalias() += M_q * offset_.segment<3>(joint);
    if (task.stance[i]) A.middleCols<3>(3 * leg) -= dynamics.foot(leg).J_leg.transpose();
    qp.A_in.middleRows<3>(row) = A;
    qp.A_in.middleRows<3>(row + 3) = -A;
    qp.b_in.segment<3>(row) = -torque_limit_.segment<3>(3 * leg) - constant;
    qp.b_in.segment<3>(row + 3) = -torque_limit_.segment<3>(3 * leg) + constant;
  }
  return true;
}

void WholeBodyQp::MakeFull(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                           const WholeBodyQpParams& params) {
  Problem& qp = full_;
  qp.H.setZero();
  qp.H.diagonal().head<18>().setConstant(params.acceleration_weight);
  qp.g.setZero();
  qp.A_eq.setZero();
  AddForceCost(dynamics, task, params, 18, &qp);
  // The feet's rows come first: they have few columns besides those of nu', which the solver makes use of.
  qp.A_eq.bottomLeftCorner<6, 18>() = dynamics.M.topRows<6>();
  qp.b_eq.tail<6>() = AboutBase(dynamics, task.disturbance) - dynamics.bias().head<6>();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const auto i = static_cast<std::size_t>(leg);
    const int joint = 6 + 3 * leg, column = 18 + 3 * leg, row = kRowsPerLeg * leg + 4;
    qp.A_eq.block<3, 18>(3 * leg, 0) = dynamics.FootJacobian(leg);
    qp.b_eq.segment<3>(3 * leg) = task.foot_acceleration[i] - dynamics.foot(leg).bias;
    auto A = qp.A_in.middleRows<3>(row);
    A.setZero();
    A.leftCols<18>() = dynamics.M.middleRows<3>(joint);
    if (task.stance[i]) {
      qp.A_eq.block<6, 3>(12, column) = -TrunkJacobian(dynamics, leg).transpose();
      A.middleCols<3>(column) = -dynamics.foot(leg).J_leg.transpose();
    } else {
      qp.A_eq.block<3, 3>(3 * leg, column) = -Eigen::Matrix3d::Identity();
    }
    const Eigen::Vector3d constant =
        dynamics.bias().segment<3>(joint) - task.joint_disturbance.segment<3>(3 * leg);
    qp.A_in.middleRows<3>(row + 3) = -A;
    qp.b_in.segment<3>(row) = -torque_limit_.segment<3>(3 * leg) - constant;
    qp.b_in.segment<3>(row + 3) = -torque_limit_.segment<3>(3 * leg) + constant;
  }
}

QpReport WholeBodyQp::Solve(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                            const WholeBodyQpParams& params, WholeBodySolution* solution) {
  const std::span<const int> guess(solution->active.data(), static_cast<std::size_t>(solution->num_active));
  eliminated_ = params.eliminate && MakeReduced(dynamics, task, params);
  if (!eliminated_) MakeFull(dynamics, task, params);
  const QpReport report = solver_.Solve(problem(), guess);
  if (!report.ok()) return report;
  const Vec<12> y = solver_.x().tail<12>();
  if (eliminated_) {
    solution->acceleration = offset_;
    solution->acceleration.noalias() += map_ * y;
  } else {
    solution->acceleration = solver_.x().head<18>();
  }
  for (int leg = 0; leg < kNumLegs; ++leg) {
    solution->force[leg].setZero();
    if (task.stance[static_cast<std::size_t>(leg)]) solution->force[leg] = y.segment<3>(3 * leg);
  }
  solution->valid = true;
  solution->stance = task.stance;
  solution->num_active = static_cast<int>(solver_.active().size());
  std::copy(solver_.active().begin(), solver_.active().end(), solution->active.begin());
  return report;
}

Vec<6> AboutBase(const QuadrupedDynamics& dynamics, const Vec<6>& wrench) {
  Vec<6> out = wrench;
  out.tail<3>() += (dynamics.com_W - dynamics.base_W).cross(wrench.head<3>());
  return out;
}

Vec<12> JointTorque(const QuadrupedDynamics& dynamics, const WholeBodySolution& solution,
                    const Vec<12>& joint_disturbance) {
  Vec<12> tau = dynamics.bias().tail<12>() - joint_disturbance;
  tau.noalias() += dynamics.M.bottomRows<12>() * solution.acceleration;
  for (int leg = 0; leg < kNumLegs; ++leg)
    tau.segment<3>(3 * leg).noalias() -= dynamics.foot(leg).J_leg.transpose() * solution.force[leg];
  return tau;
}

std::array<Vec<3>, kNumLegs> SwingFootAcceleration(const QuadrupedDynamics& dynamics,
                                                   const std::array<bool, kNumLegs>& stance,
                                                   const FootForces& force) {
  // Rows of swing feet are zero in J, and unit rows in what is solved.
  Eigen::Matrix<double, 12, 18> J = Eigen::Matrix<double, 12, 18>::Zero();
  Eigen::Matrix<double, 18, 1> push = Eigen::Matrix<double, 18, 1>::Zero();
  Matrix12 A = Matrix12::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (stance[static_cast<std::size_t>(leg)]) {
      J.middleRows<3>(3 * leg) = dynamics.FootJacobian(leg);
    } else {
      push.noalias() += dynamics.FootJacobian(leg).transpose() * force[leg];
      A.diagonal().segment<3>(3 * leg).setOnes();
    }
  }
  const Eigen::LLT<Eigen::Matrix<double, 18, 18>> mass(dynamics.M);
  const Eigen::Matrix<double, 18, 12> response = mass.solve(J.transpose());
  Eigen::Matrix<double, 18, 1> acceleration = mass.solve(push);
  A.noalias() += J * response;
  const Eigen::LDLT<Matrix12> stand(A);
  acceleration -= response * stand.solve(J * acceleration);
  std::array<Vec<3>, kNumLegs> out;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    auto& foot = out[static_cast<std::size_t>(leg)];
    foot.setZero();
    if (!stance[static_cast<std::size_t>(leg)]) foot = dynamics.FootJacobian(leg) * acceleration;
  }
  return out;
}

}  // namespace tenon
