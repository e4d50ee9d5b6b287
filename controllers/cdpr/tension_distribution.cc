#include <fmt/format.h>
#include <tenon/controllers/cdpr/tension_distribution.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tenon {
namespace {

constexpr double kRankTolerance = 1e-10;   // of the singular values, relative to the largest
constexpr double kBoundTolerance = 1e-10;  // of a tension, relative to the largest
constexpr int kMaxRows = kMaxCables + 1;
constexpr int kMaxBounds = 2 * kMaxCables;  // a lower and an upper one per cable

using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxRows, kMaxBounds>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxBounds, 1>;

// min |E y - f| with y >= 0 (Lawson and Hanson, algorithm NNLS).
SmallVector NonNegativeLeastSquares(const SmallMatrix& E, const SmallVector& f) {
  const int m = static_cast<int>(E.cols());
  SmallVector y = SmallVector::Zero(m);
  Eigen::Array<bool, Eigen::Dynamic, 1, 0, kMaxBounds, 1> passive(m);
  passive.setConstant(false);

  for (int outer = 0; outer < 4 * m; ++outer) {
    const SmallVector gradient = E.transpose() * (f - E * y);
    int enter = -1;
    double steepest = 1e-13;
    for (int j = 0; j < m; ++j) {
      if (!passive[j] && gradient[j] > steepest) {
        steepest = gradient[j];
        enter = j;
      }
    }
    if (enter < 0) break;
    passive[enter] = true;

    for (int inner = 0; inner <= m; ++inner) {
      SmallMatrix columns(E.rows(), passive.count());
      for (int j = 0, c = 0; j < m; ++j) {
        if (passive[j]) columns.col(c++) = E.col(j);
      }
      const SmallVector solution = Eigen::ColPivHouseholderQR<SmallMatrix>(columns).solve(f);
      SmallVector target = SmallVector::Zero(m);
      for (int j = 0, c = 0; j < m; ++j) {
        if (passive[j]) target[j] = solution[c++];
      }
      double step = 1;
      int leave = -1;
      for (int j = 0; j < m; ++j) {
        if (passive[j] && target[j] <= 0) {
          const double fraction = y[j] / (y[j] - target[j]);
          if (leave < 0 || fraction < step) {
            step = fraction;
            leave = j;
          }
        }
      }
      if (leave < 0) {
        y = target;
        break;
      }
      y += step * (target - y);
      y[leave] = 0;
      for (int j = 0; j < m; ++j) {
        if (passive[j] && y[j] <= 0) {
          passive[j] = false;
          y[j] = 0;
        }
      }
    }
  }
  return y;
}

// Moves u within u + span(basis) to the closest point of the box; false if they do not meet. u is normal to
// the basis, so closest to u is least norm.
bool MoveIntoBounds(const SmallMatrix& basis, double lower, double upper, CableVector* u) {
  const int n = static_cast<int>(basis.rows());
  const int k = static_cast<int>(basis.cols());
  if (k == 0) return false;

  // Rows G z >= h, divided by the largest h, as the columns [G h]^T.
  SmallMatrix E(k + 1, 2 * n);
  int rows = 0;
  for (int i = 0; i < n; ++i) {
    if (std::isfinite(lower)) E.col(rows++) << basis.row(i).transpose(), lower - (*u)[i];
    if (std::isfinite(upper)) E.col(rows++) << -basis.row(i).transpose(), (*u)[i] - upper;
  }
  const SmallMatrix bounds = E.leftCols(rows);
  const double scale = bounds.row(k).cwiseAbs().maxCoeff();
  SmallMatrix scaled = bounds;
  scaled.row(k) /= scale;

  SmallVector f = SmallVector::Zero(k + 1);
  f[k] = 1;
  const SmallVector y = NonNegativeLeastSquares(scaled, f);
  const SmallVector residual = scaled * y - f;
  if (residual.norm() < 1e-8) return false;
  *u += basis * (residual.head(k) * (-scale / residual[k]));
  return true;
}

int MostOutOfBounds(const CableVector& u, double lower, double upper) {
  int worst = 0;
  (u.array() - upper).max(lower - u.array()).maxCoeff(&worst);
  return worst;
}

bool IsWithin(const CableVector& u, double lower, double upper) {
  const double slack = kBoundTolerance * u.cwiseAbs().maxCoeff();
  return u.minCoeff() >= lower - slack && u.maxCoeff() <= upper + slack;
}

}  // namespace

TensionDistribution DistributeTension(const CableMatrix6& structure, const Vector6d& wrench,
                                      double tension_min, double tension_max, double tolerance) {
  const int n = static_cast<int>(structure.cols());
  TensionDistribution result;

  // Torques are divided by the longest lever, so that the rank does not depend on the unit of length.
  double lever = structure.bottomRows<3>().colwise().norm().maxCoeff();
  if (!(lever > 0)) lever = 1;
  CableMatrix6 A = structure;
  A.bottomRows<3>() /= lever;
  Vector6d b = wrench;
  b.tail<3>() /= lever;

  // A^T = Q R splits the tensions into those that make a wrench, u0 in the first columns of Q, and N, the
  // rest.
  Eigen::ColPivHouseholderQR<SmallMatrix> qr(A.transpose());
  qr.setThreshold(kRankTolerance);
  const int rank = static_cast<int>(qr.rank());
  const SmallMatrix Q = qr.householderQ() * SmallMatrix::Identity(n, n);
  const SmallMatrix effective = A * Q.leftCols(rank);
  const CableVector u = Q.leftCols(rank) * Eigen::ColPivHouseholderQR<SmallMatrix>(effective).solve(b);

  const Vector6d residual = wrench - structure * u;
  result.residual_force = residual.head<3>().norm();
  result.residual_torque = residual.tail<3>().norm();
  const double force_scale = wrench.head<3>().norm() + u.cwiseAbs().sum();
  const bool balanced = result.residual_force <= tolerance * force_scale &&
                        result.residual_torque <= tolerance * force_scale * lever;
  if (!balanced) {
    result.tension = u;
    result.reason = fmt::format(
        "the pose is not in static balance: whatever the tensions, {:.3g} N and {:.3g} N m "
        "of the wrench remain",
        result.residual_force, result.residual_torque);
    return result;
  }

  CableVector bounded = u;
  bool feasible = IsWithin(u, tension_min, tension_max);
  if (!feasible) {
    feasible = MoveIntoBounds(Q.rightCols(n - rank), tension_min, tension_max, &bounded);
  }
  if (!feasible) {
    const int worst = MostOutOfBounds(u, tension_min, tension_max);
    result.tension = u;
    result.reason = fmt::format(
        "no tensions within [{:g}, {:g}] N balance the wrench: cable {} of {} would need "
        "{:.2f} N{}",
        tension_min, tension_max, worst + 1, n, u[worst], rank < n ? " in the solution of least norm" : "");
    return result;
  }
  result.feasible = true;
  result.tension = bounded.cwiseMax(tension_min).cwiseMin(tension_max);
  return result;
}

}  // namespace tenon
