#include <tenon/systems/analysis/internal/period_map.h>
#include <tenon/systems/analysis/linearize_discrete.h>

#include <fmt/core.h>

#include <exception>

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

}  // namespace tenon
