#include <tenon/controllers/legged/observers/disturbance_filter.h>
#include <tenon/systems/analysis/matrix_functions.h>
#include <tenon/systems/framework/block/system.h>

#include <fmt/ranges.h>

#include <algorithm>
#include <numbers>

namespace tenon {
namespace {

std::string Text(const std::vector<std::complex<double>>& poles) {
  std::vector<std::string> texts;
  for (const std::complex<double>& pole : poles) {
    if (pole.imag() < 0) continue;  // listed with its conjugate
    texts.push_back(pole.imag() == 0 ? fmt::format("{:.3g}", pole.real())
                                     : fmt::format("{:.3g} ± {:.3g}i", pole.real(), pole.imag()));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

bool IsHurwitz(const std::vector<std::complex<double>>& poles) {
  return std::all_of(poles.begin(), poles.end(), [](const auto& pole) { return pole.real() < 0; });
}

}  // namespace

std::vector<double> GainsOfPolynomial(const std::vector<double>& coefficients) {
  std::vector<double> gains;
  for (std::size_t j = 0; j < coefficients.size(); ++j)
    gains.push_back(coefficients[j] / (j + 1 < coefficients.size() ? coefficients[j + 1] : 1));
  DemandHurwitz(gains);
  return gains;
}

std::vector<double> ButterworthGains(int order, double bandwidth) {
  Demand(order >= 1 && order <= kMaxEstimatorOrder,
         fmt::format("the order of the estimator is {} but must be from 1 to {}", order, kMaxEstimatorOrder));
  Demand(std::isfinite(bandwidth) && bandwidth > 0,
         fmt::format("the bandwidth of the estimator is {} rad/s but must be positive", bandwidth));
  const double step = std::numbers::pi / (2 * order);
  std::vector<double> gains;
  for (int i = 1; i <= order; ++i) gains.push_back(bandwidth * std::sin(i * step) / std::cos((i - 1) * step));
  return gains;
}

std::vector<std::complex<double>> EstimatorPoles(const std::vector<double>& gains) {
  const Eigen::VectorXcd values = Eigenvalues(EstimatorMatrix(gains));
  return {values.begin(), values.end()};
}

double NoiseBandwidth(const std::vector<double>& gains) {
  DemandHurwitz(gains);
  // The covariance P of gamma under white noise solves A P + P A^T + b b^T = 0, linear in its entries.
  const Eigen::MatrixXd A = EstimatorMatrix(gains);
  const Eigen::Index r = A.rows();
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(r * r, r * r);
  for (Eigen::Index i = 0; i < r; ++i) {
    equations.block(i * r, i * r, r, r) += A;
    for (Eigen::Index j = 0; j < r; ++j) equations.block(i * r, j * r, r, r).diagonal().array() += A(i, j);
  }
  Eigen::VectorXd right = Eigen::VectorXd::Zero(r * r);
  right[0] = -gains.front() * gains.front();
  return SolveLinear(equations, right)[r * r - 1] / 2;
}

void DemandHurwitz(const std::vector<double>& gains) {
  Demand(!gains.empty() && gains.size() <= std::size_t{kMaxEstimatorOrder},
         fmt::format("the estimator has {} gains: give K_1 to K_r with r from 1 to {}", gains.size(),
                     kMaxEstimatorOrder));
  const std::string list = fmt::format("{}", fmt::join(gains, ", "));
  Demand(std::all_of(gains.begin(), gains.end(), [](double gain) { return std::isfinite(gain); }),
         fmt::format("the gains {} of the estimator are not all finite; give 1/s", list));
  const auto poles = EstimatorPoles(gains);
  if (IsHurwitz(poles)) return;
  const auto reversed = EstimatorPoles({gains.rbegin(), gains.rend()});
  throw ParameterError(fmt::format(
      "with the gains {} the estimate diverges: the poles are {}; choose gains with all poles in the left "
      "half-plane{}",
      list, Text(poles),
      IsHurwitz(reversed)
          ? fmt::format(" (as the same gains in reverse order, K_1 first, have: {})", Text(reversed))
          : ""));
}

Eigen::MatrixXd EstimatorMatrix(const std::vector<double>& gains) {
  const auto r = static_cast<Eigen::Index>(gains.size());
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(r, r);
  for (Eigen::Index i = 0; i < r; ++i) {
    const double gain = gains[i];
    if (i > 0) A(i, i - 1) = gain;
    A(i, r - 1) -= gain;
  }
  return A;
}

DisturbanceFilter::DisturbanceFilter(const std::vector<double>& gains, double period) {
  DemandHurwitz(gains);
  const auto r = static_cast<Eigen::Index>(gains.size());
  // exp([[A, b], [0, 0]] T) contains the transition matrix and the integrated input matrix.
  Eigen::MatrixXd augmented = Eigen::MatrixXd::Zero(r + 1, r + 1);
  augmented.topLeftCorner(r, r) = period * EstimatorMatrix(gains);
  augmented(0, r) = period * gains.front();
  const Eigen::MatrixXd exponential = Exponential(augmented);
  transition_ = exponential.topLeftCorner(r, r);
  input_ = exponential.topRightCorner(r, 1);
}

}  // namespace tenon
