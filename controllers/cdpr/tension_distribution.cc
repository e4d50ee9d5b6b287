#include <tenon/controllers/cdpr/tension_distribution.h>

#include <Eigen/Householder>
#include <fmt/format.h>

namespace tenon {
namespace {

constexpr double kSingular = 1e-10;  // threshold of singular values, relative to the largest
constexpr double kSlack = 1e-10;     // tolerance of a tension, relative to the largest

int MostOutOfBounds(const Eigen::VectorXd& u, const CableVector& lower, const CableVector& upper) {
  int worst = 0;
  (u - upper).cwiseMax(lower - u).maxCoeff(&worst);
  return worst;
}

bool IsWithin(const Eigen::VectorXd& u, const CableVector& lower, const CableVector& upper) {
  const double slack = kSlack * u.cwiseAbs().maxCoeff();
  return (u.array() >= lower.array() - slack).all() && (u.array() <= upper.array() + slack).all();
}

}  // namespace

TensionDistributor::TensionDistributor(int num_cables)
    : qr_(num_cables, 6),
      transposed_(num_cables, 6),
      Q_(num_cables, num_cables),
      u_(num_cables),
      work_(num_cables),
      H_(Eigen::MatrixXd::Identity(num_cables, num_cables)),
      g_(Eigen::VectorXd::Zero(num_cables)),
      bounds_(2 * num_cables),
      rows_(2 * num_cables, num_cables),
      solver_(num_cables, 2 * num_cables) {
  qr_.setThreshold(kSingular);
  result_.tension.setZero(num_cables);
}

// Finds the point of u_ + span(N) in the box that is closest to u_; returns false if there is none. u_ is
// normal to N, so the closest point has the least norm.
bool TensionDistributor::MoveIntoBounds(int rank, const CableVector& lower, const CableVector& upper) {
  const Eigen::Index n = Q_.rows(), k = n - rank;
  if (k == 0) return false;
  const auto N = Q_.rightCols(k);
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (std::isfinite(lower[i])) {
      rows_.row(count).head(k) = N.row(i);
      bounds_[count++] = lower[i] - u_[i];
    }
    if (std::isfinite(upper[i])) {
      rows_.row(count).head(k) = -N.row(i);
      bounds_[count++] = u_[i] - upper[i];
    }
  }
  const QpReport report =
      solver_.Solve({H_.topLeftCorner(k, k), g_.head(k), rows_.topLeftCorner(0, k), bounds_.head(0),
                     rows_.topLeftCorner(count, k), bounds_.head(count)});
  if (!report.ok()) return false;
  result_.tension = u_;
  result_.tension.noalias() += N * solver_.x();
  return true;
}

const TensionDistribution& TensionDistributor::Solve(const CableMatrix6& structure, const Vector6d& wrench,
                                                     const CableVector& tension_min,
                                                     const CableVector& tension_max, double tolerance) {
  const Eigen::Index n = Q_.rows();
  if (structure.cols() != n)
    throw ParameterError(
        fmt::format("the structure matrix has {} columns, but this distributes the tensions of {} cables",
                    structure.cols(), n));
  result_.feasible = false;
  result_.reason.clear();

  // Torques are divided by the longest lever, so that the rank does not depend on the unit of length.
  double lever = structure.bottomRows<3>().colwise().norm().maxCoeff();
  if (!(lever > 0)) lever = 1;
  transposed_ = structure.transpose();
  transposed_.rightCols<3>() /= lever;
  Vector6d b = wrench;
  b.tail<3>() /= lever;

  // The decomposition W^T = Q R separates the tensions that produce a wrench, u_ in the first columns of Q,
  // from the null space N, spanned by the remaining columns.
  qr_.compute(transposed_);
  const int rank = static_cast<int>(qr_.rank());
  Q_.setIdentity();
  for (Eigen::Index i = qr_.hCoeffs().size() - 1; i >= 0; --i) {
    Q_.bottomRows(n - i).applyHouseholderOnTheLeft(qr_.matrixQR().col(i).tail(n - i - 1), qr_.hCoeffs()[i],
                                                   work_.data());
  }
  using Effective = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;
  Effective effective(6, rank);
  effective.noalias() = transposed_.transpose() * Q_.leftCols(rank);
  const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> parts =
      Eigen::ColPivHouseholderQR<Effective>(effective).solve(b);
  u_.noalias() = Q_.leftCols(rank) * parts;
  result_.tension = u_;

  Vector6d residual = wrench;
  residual.noalias() -= structure * u_;
  result_.residual_force = residual.head<3>().norm();
  result_.residual_torque = residual.tail<3>().norm();
  const double force_scale = wrench.head<3>().norm() + u_.cwiseAbs().sum();
  const bool balanced = result_.residual_force <= tolerance * force_scale &&
                        result_.residual_torque <= tolerance * force_scale * lever;
  if (!balanced) {
    result_.reason = fmt::format(
        "the pose is not in static balance: whatever the tensions, {:.3g} N and {:.3g} N m "
        "of the wrench remain",
        result_.residual_force, result_.residual_torque);
    return result_;
  }
  if (!IsWithin(u_, tension_min, tension_max) && !MoveIntoBounds(rank, tension_min, tension_max)) {
    const int worst = MostOutOfBounds(u_, tension_min, tension_max);
    result_.reason = fmt::format(
        "no tensions within [{:g}, {:g}] N balance the wrench: cable {} of {} would need "
        "{:.2f} N{}",
        tension_min[worst], tension_max[worst], worst, n, u_[worst],
        rank < n ? " in the solution of least norm" : "");
    return result_;
  }
  result_.feasible = true;
  result_.tension = result_.tension.cwiseMax(tension_min).cwiseMin(tension_max);
  return result_;
}

TensionDistribution DistributeTension(const CableMatrix6& structure, const Vector6d& wrench,
                                      const CableVector& tension_min, const CableVector& tension_max,
                                      double aim, double tolerance) {
  TensionDistributor distributor(static_cast<int>(structure.cols()));
  if (aim != 0) {
    const CableVector middle = CableVector::Constant(structure.cols(), aim);
    TensionDistribution found = distributor.Solve(structure, wrench - structure * middle,
                                                  tension_min - middle, tension_max - middle, tolerance);
    found.tension += middle;
    if (found.feasible) return found;  // otherwise its reason would name other bounds
  }
  return distributor.Solve(structure, wrench, tension_min, tension_max, tolerance);
}

}  // namespace tenon
