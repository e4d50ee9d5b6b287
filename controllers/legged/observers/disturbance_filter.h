#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/signal.h>

#include <Eigen/Core>

#include <complex>
#include <vector>

namespace tenon {

/// The gains K_1 ... K_r [1/s] of the linear estimator that momentum-based observers are made of (Morlando
/// 2023, eqs. (2.9) to (2.13)). Of a disturbance F it makes F_hat = gamma_r with
///
///     gamma_1' = K_1 (F - gamma_r),   gamma_i' = K_i (gamma_(i-1) - gamma_r),   i = 2 ... r,
///
/// that is F_hat / F = c_0 / (s^r + c_(r-1) s^(r-1) + ... + c_0) with c_j = K_(j+1) K_(j+2) ... K_r. (The
/// thesis prints its gains in the opposite order, with which the estimate diverges.)
inline constexpr int kMaxEstimatorOrder = 12;

/// The gains of a polynomial c_0, ..., c_(r-1), the leading coefficient being 1: K_(j+1) = c_j / c_(j+1).
/// Throws ParameterError for what DemandHurwitz refuses.
std::vector<double> GainsOfPolynomial(const std::vector<double>& coefficients);

/// Butterworth's polynomial: flat up to the bandwidth w [rad/s], where a sine has lost 3 dB,
///
///     K_i = w sin(i pi / 2r) / cos((i - 1) pi / 2r);
///
/// order 1 is the low-pass of gain w, order 3 is (w/2, w, 2w). Throws ParameterError unless the order is from
/// 1 to kMaxEstimatorOrder and the bandwidth positive.
std::vector<double> ButterworthGains(int order, double bandwidth);

/// An estimator by its order and bandwidth, see ButterworthGains.
struct ButterworthDesign {
  int order = 1;           ///< of the estimator
  double bandwidth = 100;  ///< where its gain has fallen by 3 dB [rad/s]

  static FieldList Fields() {
    return {Required("order", &ButterworthDesign::order),
            Required("bandwidth_rad_per_s", &ButterworthDesign::bandwidth)};
  }
};

/// The roots of the characteristic polynomial [1/s].
std::vector<std::complex<double>> EstimatorPoles(const std::vector<double>& gains);

/// The noise-equivalent bandwidth [Hz]: white noise of density S comes out with a variance of S times this,
/// half the integral of the squared impulse response. K / 4 for order 1.
double NoiseBandwidth(const std::vector<double>& gains);

/// Throws ParameterError, with the roots, unless all of them lie in the left half-plane; and if there are no
/// gains, too many, or some are not finite.
void DemandHurwitz(const std::vector<double>& gains);

/// A of gamma' = A gamma + (K_1, 0, ..., 0) F, the estimator above.
Eigen::MatrixXd EstimatorMatrix(const std::vector<double>& gains);

/// That estimator in samples: exact for a disturbance that is constant over each
/// interval, and so in the mean for any other, by the matrix exponential, which is computed once.
class DisturbanceFilter {
 public:
  /// gamma_1 ... gamma_r of N disturbances, in columns; the last is the estimate.
  template <int N>
  using Memory = Eigen::Matrix<double, N, Eigen::Dynamic, Eigen::DontAlign, N, kMaxEstimatorOrder>;

  /// Not a filter yet: good to be assigned to.
  DisturbanceFilter() = default;
  /// `period` in s. Throws what DemandHurwitz throws.
  DisturbanceFilter(const std::vector<double>& gains, double period);

  template <int N>
  Memory<N> Start() const {
    return Memory<N>::Zero(N, input_.size());
  }
  /// The memory of a filter of another order goes on in this one, at rest at its estimate.
  template <int N>
  void Fit(Memory<N>* memory) const {
    if (memory->cols() == input_.size()) return;
    const Vec<N> estimate = Estimate<N>(*memory);
    *memory = estimate.replicate(1, input_.size());
  }
  /// Past an interval with the mean disturbance `mean`; no allocation.
  template <int N>
  void Advance(const Vec<N>& mean, Memory<N>* memory) const {
    const Memory<N> before = *memory;
    memory->noalias() = before.lazyProduct(transition_.transpose()) + mean.lazyProduct(input_.transpose());
  }
  template <int N>
  static Vec<N> Estimate(const Memory<N>& memory) {
    return memory.col(memory.cols() - 1);
  }

 private:
  Eigen::MatrixXd transition_;
  Eigen::VectorXd input_;
};

}  // namespace tenon
