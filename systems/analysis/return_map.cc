#include <tenon/systems/analysis/internal/period_map.h>
#include <tenon/systems/analysis/matrix_functions.h>
#include <tenon/systems/analysis/return_map.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>

namespace tenon {
namespace {

/// Converts numbers given by the names of states to a vector.
Eigen::VectorXd ByName(const std::map<std::string, double>& values, const std::vector<std::string>& names) {
  Eigen::VectorXd vector = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(names.size()));
  for (const auto& [name, value] : values) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      throw ParameterError(fmt::format("there is no state '{}' in the return map; did you mean '{}'?", name,
                                       internal::NearestName(name, names)));
    }
    vector[found - names.begin()] = value;
  }
  return vector;
}

/// The eigenvalues by descending magnitude.
Eigen::VectorXcd Multipliers(const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0) return {};
  Eigen::VectorXcd values = Eigenvalues(matrix);
  std::stable_sort(values.begin(), values.end(),
                   [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
  return values;
}

}  // namespace

ReturnMapResult ReturnMap(const Context& context, const ReturnMapOptions& options) {
  Simulator settled(context.Clone(), internal::Silent(options.map).simulator);
  if (options.settle_periods > 0) {
    const double period = internal::PeriodOf(context.diagram(), options.map);
    internal::RunToBefore(settled, context.time() + options.settle_periods * period);
  }
  const internal::PeriodMap map(settled.context(), {}, {}, options.map);
  const std::vector<std::string>& names = map.states().names();
  const Eigen::VectorXd advance = ByName(options.advance, names);

  // The directions as columns, each state divided by its scale.
  std::vector<Eigen::VectorXd> directions;
  for (const auto& direction : options.neutral) directions.push_back(ByName(direction, names));
  if (options.time_is_neutral) directions.push_back(map.Rates());
  const auto n = static_cast<Eigen::Index>(names.size());
  const auto k = static_cast<Eigen::Index>(directions.size());
  Eigen::MatrixXd neutral(n, k);
  for (Eigen::Index i = 0; i < k; ++i) {
    neutral.col(i) = directions[static_cast<std::size_t>(i)].cwiseQuotient(map.scales).normalized();
  }
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(n, n);
  if (k > 0) {
    const RangeBasis range = CalcRangeBasis(neutral);
    if (range.rank < k) {
      throw ParameterError("the neutral directions are zero or linearly dependent; remove some");
    }
    basis = range.Q;
  }

  ReturnMapResult result;
  result.map = internal::LinearizePeriod(map, [&](const Eigen::VectorXd& x1) -> Eigen::VectorXd {
    const Eigen::VectorXd back = options.bring_back ? options.bring_back(x1) : x1;
    if (back.size() == n) return back - advance;
    throw ParameterError(fmt::format("bring_back returns {} numbers for {} states", back.size(), n));
  });
  result.residual = result.map.x1 - result.map.x0;

  const Eigen::MatrixXd scaled =
      map.scales.cwiseInverse().asDiagonal() * result.map.A * map.scales.asDiagonal();
  const Eigen::MatrixXd turned = basis.transpose() * scaled * basis;
  result.neutral_multipliers = Multipliers(turned.topLeftCorner(k, k));
  result.multipliers = Multipliers(turned.bottomRightCorner(n - k, n - k));
  result.neutral_defect = turned.bottomLeftCorner(n - k, k).norm();
  return result;
}

}  // namespace tenon
