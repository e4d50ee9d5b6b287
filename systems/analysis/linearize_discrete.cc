#include <tenon/systems/analysis/internal/period_map.h>
#include <tenon/systems/analysis/linearize_discrete.h>
#include <tenon/systems/analysis/matrix_functions.h>
#include <tenon/systems/analysis/return_map.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>

namespace tenon {
namespace internal {
namespace {

/// Returns above - below, 0 for a number that is not finite in both.
Eigen::VectorXd Difference(const Eigen::VectorXd& above, const Eigen::VectorXd& below) {
  if (above.size() != below.size()) {
    throw RunError(
        fmt::format("the outputs hold {} numbers in one run and {} in another: signals of variable size have "
                    "no derivative",
                    above.size(), below.size()));
  }
  Eigen::VectorXd difference = above - below;
  for (Eigen::Index i = 0; i < difference.size(); ++i) {
    if (!std::isfinite(above[i]) && !std::isfinite(below[i])) difference[i] = 0;
  }
  return difference;
}

}  // namespace

DiscreteLinearModel LinearizePeriod(
    const PeriodMap& map, const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& bring_back) {
  const std::vector<double>& steps = map.options().steps;
  const auto run = [&](const Eigen::VectorXd& from) {
    PeriodMap::End end = map.Run(from);
    if (bring_back) end.x1 = bring_back(end.x1);
    return end;
  };
  const PeriodMap::End nominal = run(map.origin);
  const Eigen::Index n = map.states().size(), m = map.inputs().size(), p = nominal.y.size();

  DiscreteLinearModel model;
  model.states = map.states().names();
  model.inputs = map.inputs().names();
  model.outputs = map.OutputNames(nominal);
  model.time = map.time;
  model.period = map.period;
  model.x0 = map.origin.head(n);
  model.u0 = map.origin.tail(m);
  model.x1 = nominal.x1;
  model.y0 = nominal.y;
  model.spread = Eigen::VectorXd::Zero(n + m);

  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(n + p, n + m);
  Eigen::MatrixXd estimates(n + p, static_cast<Eigen::Index>(steps.size()));
  for (Eigen::Index i = 0; i < n + m; ++i) {
    const std::string& moved =
        i < n ? model.states[static_cast<std::size_t>(i)] : model.inputs[static_cast<std::size_t>(i - n)];
    const auto run_at = [&](double value) {
      Eigen::VectorXd from = map.origin;
      from[i] = value;
      PeriodMap::End end = [&] {
        try {
          return run(from);
        } catch (const Error& error) {
          std::throw_with_nested(
              RunError(fmt::format("with '{}' moved to {}: {}", moved, value, error.what())));
        }
      }();
      for (std::string& signal : map.Flips(nominal, end)) {
        const auto known = [&](const Flip& flip) { return flip.signal == signal && flip.moved == moved; };
        if (std::any_of(model.flips.begin(), model.flips.end(), known)) continue;
        model.flips.push_back({std::move(signal), moved});
      }
      return end;
    };
    if (!std::isfinite(map.origin[i])) continue;
    for (Eigen::Index k = 0; k < estimates.cols(); ++k) {
      const double step = steps[static_cast<std::size_t>(k)] * map.scales[i];
      const double high = map.origin[i] + step, low = map.origin[i] - step;
      const PeriodMap::End above = run_at(high), below = run_at(low);
      const Eigen::VectorXd dx = Difference(above.x1, below.x1), dy = Difference(above.y, below.y);
      estimates.col(k) << dx, dy;
      estimates.col(k) /= high - low;
    }
    if (n + p == 0) continue;
    slopes.col(i) = estimates.rowwise().mean();
    model.spread[i] = (estimates.colwise() - slopes.col(i)).cwiseAbs().maxCoeff();
  }
  if (map.options().refuse_flips && !model.flips.empty()) {
    throw RunError(
        fmt::format("the map jumps: '{}' changes when '{}' is varied; use a smaller step or another time",
                    model.flips.front().signal, model.flips.front().moved));
  }
  model.A = slopes.topLeftCorner(n, n);
  model.B = slopes.topRightCorner(n, m);
  model.C = slopes.bottomLeftCorner(p, n);
  model.D = slopes.bottomRightCorner(p, m);
  return model;
}

}  // namespace internal

DiscreteLinearModel LinearizeDiscrete(const Context& context, const std::vector<const Source*>& inputs,
                                      const std::vector<const Source*>& outputs,
                                      const LinearizeDiscreteOptions& options) {
  return internal::LinearizePeriod(internal::PeriodMap(context, inputs, outputs, options), nullptr);
}

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
