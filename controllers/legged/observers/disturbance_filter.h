#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <complex>

namespace tenon {

/// Maximum order r of the linear estimator in momentum-based observers (Morlando 2023, eqs. (2.9) to (2.13)).
/// With gains K_1 ... K_r [1/s] it estimates a disturbance F by F_hat = gamma_r,
///
///     gamma_1' = K_1 (F - gamma_r),   gamma_i' = K_i (gamma_(i-1) - gamma_r),   i = 2 ... r,
///
/// which is F_hat / F = c_0 / (s^r + c_(r-1) s^(r-1) + ... + c_0) with c_j = K_(j+1) K_(j+2) ... K_r. (The
/// thesis prints its gains in reverse order, with which the estimate diverges.)
inline constexpr int kMaxEstimatorOrder = 12;

/// The gains of a polynomial c_0, ..., c_(r-1), the leading coefficient being 1: K_(j+1) = c_j / c_(j+1).
/// Throws ParameterError under the conditions of DemandHurwitz.
std::vector<double> GainsOfPolynomial(const std::vector<double>& coefficients);

/// Gains of a Butterworth filter with the cut-off frequency w [rad/s], where the gain has dropped by 3 dB:
///
///     K_i = w sin(i pi / 2r) / cos((i - 1) pi / 2r);
///
/// (w) for order 1, (w/2, w, 2w) for order 3. Throws ParameterError unless the order is from
/// 1 to kMaxEstimatorOrder and the bandwidth positive.
std::vector<double> ButterworthGains(int order, double bandwidth);

/// Order and bandwidth of an estimator designed by ButterworthGains.
struct ButterworthDesign {
  int order = 1;           ///< order of the estimator
  double bandwidth = 100;  ///< cut-off frequency at -3 dB [rad/s]

  static FieldList Fields() {
    return {Required("order", &ButterworthDesign::order),
            Required("bandwidth_rad_per_s", &ButterworthDesign::bandwidth)};
  }
};

/// The roots of the characteristic polynomial [1/s].
std::vector<std::complex<double>> EstimatorPoles(const std::vector<double>& gains);

/// The noise-equivalent bandwidth [Hz], half the integral of the squared impulse response: white noise of
/// one-sided density S yields an estimate with variance S times this bandwidth. K / 4 for order 1.
double NoiseBandwidth(const std::vector<double>& gains);

/// Throws ParameterError if there are no gains or more than kMaxEstimatorOrder, if one is not finite, or if a
/// pole of the estimator is not in the left half-plane; the message lists the poles.
void DemandHurwitz(const std::vector<double>& gains);

/// System matrix A of the estimator gamma' = A gamma + (K_1, 0, ..., 0) F.
Eigen::MatrixXd EstimatorMatrix(const std::vector<double>& gains);

/// The estimator in discrete time, by the matrix exponential: exact for a disturbance that is constant over
/// each interval.
class DisturbanceFilter {
 public:
  /// State of N estimators: columns gamma_1 ... gamma_r, of which the last is the estimate.
  template <int N>
  using Memory = Eigen::Matrix<double, N, Eigen::Dynamic, Eigen::DontAlign, N, kMaxEstimatorOrder>;

  /// An empty filter, to be assigned to.
  DisturbanceFilter() = default;
  /// `period` in s. Throws ParameterError under the conditions of DemandHurwitz.
  DisturbanceFilter(const std::vector<double>& gains, double period);

  template <int N>
  Memory<N> Start() const {
    return Memory<N>::Zero(N, input_.size());
  }
  /// Adapts the state of a filter of another order to this one, at rest at its estimate.
  template <int N>
  void Fit(Memory<N>* memory) const {
    if (memory->cols() == input_.size()) return;
    const Vec<N> estimate = Estimate<N>(*memory);
    *memory = estimate.replicate(1, input_.size());
  }
  /// Advances the state by one interval with the mean disturbance `mean`. Does not allocate.
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
