#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>
#include <tenon/systems/framework/block/system.h>

#include <Eigen/LU>

#include <numbers>

namespace tenon {
namespace {

using internal::Lanes;
using internal::PacketAt;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

// J_leg counts as singular if |det J_leg| <= kStraight |J_leg|^3.
constexpr double kStraight = 1e-4;
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
// A wanted tangential force of less than this part of the force does not turn the inscribed pyramid.
constexpr double kSlight = 0.02;

// Layout of a row that stores an affine function of y = (f, gamma): twelve coefficients, the constant, and
// zeros as padding.
constexpr int kWidth = 16, kConstant = 12;

// Layout of all rows: the 18 accelerations nu', then the error of the wrench from kWrenchRow on.
constexpr int kWrenchRow = 18, kRows = 24;

// row += s * other
[[gnu::always_inline]] inline void AddRow(double s, const double* other, double* row) {
  for (int i = 0; i < kWidth; i += 4) *PacketAt(row + i) += *PacketAt(other + i) * s;
}

// Solves A x = B y for the six rows x by Gauss-Jordan elimination with row pivots. Each of `rows` holds a row
// of B, then one of A from kWidth on. A singular A yields values that are not finite.
constexpr int kEliminationWidth = kWidth + 8;
[[gnu::always_inline]] inline void Eliminate(double* rows, double* solution) {
  std::array<double*, 6> at{};
  for (std::size_t i = 0; i < 6; ++i) at[i] = rows + i * kEliminationWidth;
  for (std::size_t k = 0; k < 6; ++k) {
    std::size_t largest = k;
    for (std::size_t i = k + 1; i < 6; ++i)
      if (std::abs(at[i][kWidth + k]) > std::abs(at[largest][kWidth + k])) largest = i;
    std::swap(at[k], at[largest]);
    double* const pivot = at[k];
    const double inverse = 1 / pivot[kWidth + k];
    for (int c = 0; c < kEliminationWidth; c += 4) *PacketAt(pivot + c) = *PacketAt(pivot + c) * inverse;
    for (std::size_t i = 0; i < 6; ++i) {
      if (i == k) continue;
      const double factor = -at[i][kWidth + k];
      for (int c = 0; c < kEliminationWidth; c += 4) *PacketAt(at[i] + c) += *PacketAt(pivot + c) * factor;
    }
  }
  for (std::size_t k = 0; k < 6; ++k)
    for (int c = 0; c < kWidth; c += 4) *PacketAt(solution + k * kWidth + c) = *PacketAt(at[k] + c);
}

// H = sum w a a^T over rows (a, c) with weights w: the lower triangle and parts of the upper one, columns in
// groups of four.
template <int first = 0>
[[gnu::always_inline]] inline void SumSquares(const double* rows, const double* weights, double* H) {
  constexpr int packets = 3 - first / 4;
  Lanes sum[4][packets] = {};
  for (int r = 0; r < kRows; ++r) {
    const double* const row = rows + r * kWidth + first;
    for (int c = 0; c < 4; ++c) {
      const double factor = weights[r] * row[c];
      for (int p = 0; p < packets; ++p) sum[c][p] += *PacketAt(row + 4 * p) * factor;
    }
  }
  for (int c = 0; c < 4; ++c)
    for (int p = 0; p < packets; ++p) *PacketAt(H + 12 * (first + c) + first + 4 * p) = sum[c][p];
  if constexpr (first < 8) SumSquares<first + 4>(rows, weights, H);
}
// g = sum w c a over rows (a, c) with weights w.
[[gnu::always_inline]] inline void SumProducts(const double* rows, const double* weights, double* g) {
  Lanes sum[3] = {};
  for (int r = 0; r < kRows; ++r) {
    const double* const row = rows + r * kWidth;
    const double factor = weights[r] * row[kConstant];
    for (int p = 0; p < 3; ++p) sum[p] += *PacketAt(row + 4 * p) * factor;
  }
  for (int p = 0; p < 3; ++p) *PacketAt(g + 4 * p) = sum[p];
}

// Inverse of a singular leg Jacobian with its singular values raised to 2 kStraight |J|, a lower bound of
// those of every regular one. NaN if J is not finite: the decomposition writes no result then.
Eigen::Matrix3d InverseOfSingular(const Eigen::Matrix3d& J) {
  const internal::SingularValues3 svd = internal::CalcSingularValues3(J);
  if (!svd.valid) return Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const Eigen::Vector3d values = svd.values.cwiseMax(2 * kStraight * J.norm());
  return svd.V * values.cwiseInverse().asDiagonal() * svd.U.transpose();
}

// The trunk's columns of the foot's Jacobian.
Eigen::Matrix<double, 3, 6> TrunkJacobian(const QuadrupedDynamics& dynamics, int leg) {
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -CrossMatrix(dynamics.foot(leg).p_W - dynamics.base_W);
  return J;
}

}  // namespace

WholeBodyQp::WholeBodyQp(const Vec<12>& torque_limit)
    : torque_limit_(torque_limit),
      H_(Eigen::MatrixXd::Zero(12, 12)),
      g_(Eigen::VectorXd::Zero(12)),
      A_eq_(ConstraintMatrix::Zero(0, 12)),
      A_in_(ConstraintMatrix::Zero(kMaxRows, 12)),
      b_eq_(Eigen::VectorXd::Zero(0)),
      b_in_(Eigen::VectorXd::Zero(kMaxRows)) {
  Demand((torque_limit.array() > 0).all(), "the torque limits of all joints must be positive");
  affine_.Resize(kRows * kWidth);
}

Vec<3> FirstTangent(const Vec<3>& normal) {
  return (Vec<3>::UnitX() - normal[0] * normal).normalized();
}

// Writes the rows of the friction pyramids.
void WholeBodyQp::MakePyramids(const WholeBodyTask& task, const WholeBodyQpParams& params) {
  const Vec<3>& n = task.normal_W;
  const bool octagonal = params.friction_pyramid == FrictionPyramid::kOctagonal;
  double friction = params.friction;
  Eigen::Vector3d t_1 = FirstTangent(n);
  if (params.friction_pyramid != FrictionPyramid::kCircumscribed) {
    const Eigen::Vector3d wanted = task.wrench.head<3>() - task.disturbance.head<3>();
    const Eigen::Vector3d along = wanted - wanted.dot(n) * n;
    if (along.norm() > kSlight * wanted.norm()) t_1 = along.normalized();
    // tan and cos of the angle from an edge to the middle of a side
    const double slope = octagonal ? std::numbers::sqrt2 - 1 : 1;
    const double ratio = octagonal ? std::sqrt(2 + std::numbers::sqrt2) / 2 : std::numbers::sqrt2 / 2;
    t_1 = (t_1 + slope * n.cross(t_1)).normalized();
    friction *= ratio;
  }
  const auto write = [&](int leg, int row, const Eigen::Vector3d& t_1, const Eigen::Vector3d& t_2) {
    const bool stance = task.stance[leg];
    A_in_.middleRows<4>(row).setZero();
    b_in_.segment<4>(row).setConstant(stance ? 0 : -1);
    if (!stance) return;
    auto pyramid = A_in_.block<4, 3>(row, 3 * leg);
    pyramid.row(0) = (friction * n + t_1).transpose();
    pyramid.row(1) = (friction * n - t_1).transpose();
    pyramid.row(2) = (friction * n + t_2).transpose();
    pyramid.row(3) = (friction * n - t_2).transpose();
  };
  const Eigen::Vector3d t_2 = n.cross(t_1);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    write(leg, kRowsPerLeg * leg, t_1, t_2);
    if (octagonal)
      write(leg, kNumLegs * (kRowsPerLeg + 1) + 4 * leg, (t_1 + t_2).normalized(), (t_2 - t_1).normalized());
  }
}

// Writes the bounds of the loads, and sets the number of rows. The bounds are not part of the program if
// there are none and no rows follow.
void WholeBodyQp::BoundLoads(const WholeBodyTask& task, const WholeBodyQpParams& params) {
  const bool octagonal = params.friction_pyramid == FrictionPyramid::kOctagonal;
  num_rows_ = kNumLegs * kRowsPerLeg;
  if (!octagonal && (task.largest_load.array() == kUnlimited).all()) return;
  for (int leg = 0; leg < kNumLegs; ++leg, ++num_rows_) {
    const bool bounded = task.stance[leg] && task.largest_load[leg] < kUnlimited;
    A_in_.row(num_rows_).setZero();
    b_in_[num_rows_] = bounded ? -task.largest_load[leg] : -1;
    if (bounded) A_in_.block<1, 3>(num_rows_, 3 * leg) = -task.normal_W.transpose();
  }
  if (octagonal) num_rows_ = kMaxRows;
}

// Writes the program in f and gamma. The rows of `affine_` become nu' and the error of the wrench; see
// **Elimination** in the header.
TENON_VECTOR_CLONES void WholeBodyQp::MakeProblem(const QuadrupedDynamics& dynamics,
                                                  const WholeBodyTask& task,
                                                  const WholeBodyQpParams& params) {
  double* const rows = affine_.data();
  for (int i = 0; i < kRows * kWidth; i += 4) *PacketAt(rows + i) = Lanes{};
  std::array<Eigen::Matrix3d, kNumLegs> inverse;
  std::array<Eigen::Matrix<double, 3, 6>, kNumLegs> by_trunk;
  Eigen::Matrix<double, 6, 6> S = dynamics.M.topLeftCorner<6, 6>();
  Eigen::Matrix<double, 6, 13> right;  // S a_b = right (y, 1)
  right.col(12) =
      AboutBase(dynamics, task.disturbance) - dynamics.coriolis.head<6>() - dynamics.gravity.head<6>();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const Eigen::Matrix3d& J = dynamics.foot(leg).J_leg;
    const double size2 = J.squaredNorm();
    const bool regular = std::abs(J.determinant()) > kStraight * size2 * std::sqrt(size2);
    inverse[leg] = regular ? Eigen::Matrix3d(J.inverse()) : InverseOfSingular(J);  // inlined for the clones
    const auto J_b = TrunkJacobian(dynamics, leg);
    const auto M_b = dynamics.M.block<6, 3>(0, 6 + 3 * leg);
    by_trunk[leg].noalias() = -inverse[leg] * J_b;
    const Eigen::Vector3d joints = inverse[leg] * (task.foot_acceleration[leg] - dynamics.foot(leg).bias);
    for (int k = 0; k < 3; ++k) rows[(6 + 3 * leg + k) * kWidth + kConstant] = joints[k];
    S.noalias() += M_b.lazyProduct(by_trunk[leg]);
    right.col(12).noalias() -= M_b * joints;
    if (task.stance[leg])
      right.middleCols<3>(3 * leg) = J_b.transpose();
    else
      right.middleCols<3>(3 * leg) = -M_b.lazyProduct(inverse[leg]);
  }
  alignas(32) double elimination[6 * kEliminationWidth] = {};
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 13; ++c) elimination[r * kEliminationWidth + c] = right(r, c);
    for (int c = 0; c < 6; ++c) elimination[r * kEliminationWidth + kWidth + c] = S(r, c);
  }
  Eliminate(elimination, rows);

  for (int leg = 0; leg < kNumLegs; ++leg) {
    for (int k = 0; k < 3; ++k) {
      double* const row = rows + (6 + 3 * leg + k) * kWidth;
      if (!task.stance[leg])
        for (int c = 0; c < 3; ++c) row[3 * leg + c] = inverse[leg](k, c);
      for (int r = 0; r < 6; ++r) AddRow(by_trunk[leg](k, r), rows + r * kWidth, row);
    }
  }
  std::array<double, kRows> weights;
  weights.fill(params.acceleration_weight);
  const Vec<6> wrench = task.wrench - task.disturbance, Q = params.WrenchWeights(task.tilt, task.turn);
  for (int r = 0; r < 6; ++r) {
    rows[(kWrenchRow + r) * kWidth + kConstant] = -wrench[r];
    weights[kWrenchRow + r] = Q[r];
  }
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (!task.stance[leg]) continue;
    const Eigen::Matrix3d arm = CrossMatrix(dynamics.foot(leg).p_W - dynamics.com_W);
    for (int r = 0; r < 3; ++r) {
      rows[(kWrenchRow + r) * kWidth + 3 * leg + r] = 1;
      for (int c = 0; c < 3; ++c) rows[(kWrenchRow + 3 + r) * kWidth + 3 * leg + c] = arm(r, c);
    }
  }
  SumSquares(rows, weights.data(), H_.data());
  SumProducts(rows, weights.data(), g_.data());
  for (int y = 0; y < 12; ++y) H_(y, y) += task.stance[y / 3] ? params.force_weight : params.slack_weight;

  MakePyramids(task, params);
  BoundLoads(task, params);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    for (int k = 0; k < 3; ++k) {
      const int joint = 3 * leg + k, lower = kRowsPerLeg * leg + 4 + k, upper = lower + 3;
      alignas(32) double torque[kWidth] = {};
      if (task.stance[leg])
        for (int c = 0; c < 3; ++c) torque[3 * leg + c] = -dynamics.foot(leg).J_leg(c, k);
      torque[kConstant] =
          dynamics.coriolis[6 + joint] + dynamics.gravity[6 + joint] - task.joint_disturbance[joint];
      for (int r = 0; r < 6; ++r) AddRow(dynamics.M(r, 6 + joint), rows + r * kWidth, torque);
      for (int r = 0; r < 3; ++r)
        AddRow(dynamics.M(6 + 3 * leg + r, 6 + joint), rows + (6 + 3 * leg + r) * kWidth, torque);
      for (int c = 0; c < 12; c += 4) {
        *PacketAt(&A_in_(lower, c)) = *PacketAt(torque + c);
        *PacketAt(&A_in_(upper, c)) = -*PacketAt(torque + c);
      }
      b_in_[lower] = -torque_limit_[joint] - torque[kConstant];
      b_in_[upper] = -torque_limit_[joint] + torque[kConstant];
    }
  }
}

QpReport WholeBodyQp::Solve(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                            const WholeBodyQpParams& params, WholeBodySolution* solution) {
  const std::span<const int> guess(solution->active.data(), static_cast<std::size_t>(solution->num_active));
  MakeProblem(dynamics, task, params);
  const QpReport report = solver_.Solve(problem(), guess);
  if (!report.ok()) return report;
  const Vec<12> y = solver_.x();
  alignas(32) double forces[12], acceleration[20];
  Vec<12>::Map(forces) = y;
  internal::Products(affine_.data(), kWidth, 18, forces, internal::KnownSize<12>(), acceleration);
  for (int r = 0; r < 18; ++r) solution->acceleration[r] = acceleration[r] + affine_[r * kWidth + kConstant];
  for (int leg = 0; leg < kNumLegs; ++leg) {
    solution->force[leg].setZero();
    if (task.stance[leg]) solution->force[leg] = y.segment<3>(3 * leg);
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
  // J has zero rows for swing feet, and A the corresponding rows of the identity.
  Eigen::Matrix<double, 12, 18> J = Eigen::Matrix<double, 12, 18>::Zero();
  Eigen::Matrix<double, 18, 1> push = Eigen::Matrix<double, 18, 1>::Zero();
  Matrix12 A = Matrix12::Zero();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (stance[leg]) {
      J.middleRows<3>(3 * leg) = dynamics.FootJacobian(leg);
    } else {
      push.noalias() += dynamics.FootJacobian(leg).transpose() * force[leg];
      A.diagonal().segment<3>(3 * leg).setOnes();
    }
  }
  const internal::Cholesky<18> mass(dynamics.M);
  const Eigen::Matrix<double, 18, 12> response = mass.Solve<12>(J.transpose());
  Eigen::Matrix<double, 18, 1> acceleration = mass.Solve<1>(push);
  A.noalias() += J * response;
  acceleration -= response * internal::SolveLdlt<12>(A, J * acceleration);
  std::array<Vec<3>, kNumLegs> out;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    auto& foot = out[leg];
    foot.setZero();
    if (!stance[leg]) foot = dynamics.FootJacobian(leg) * acceleration;
  }
  return out;
}

}  // namespace tenon
