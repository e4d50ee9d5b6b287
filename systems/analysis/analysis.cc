#include <tenon/systems/analysis/analysis.h>
#include <tenon/systems/analysis/internal/period_map.h>
#include <tenon/systems/analysis/sensitivity.h>
#include <tenon/systems/framework/diagram/internal/program.h>

#include <Eigen/QR>
#include <fmt/core.h>
#include <unsupported/Eigen/NonLinearOptimization>

#include <exception>

namespace tenon {
namespace {

/// The continuous states and the real numbers of the chosen inputs as one vector.
internal::RealNumbers StatesAnd(const std::vector<const Source*>& inputs, const Context& context) {
  std::vector<const Source*> all = context.diagram().program().continuous;
  all.insert(all.end(), inputs.begin(), inputs.end());
  return {context, std::move(all)};
}

double Step(double value) {
  return 1e-6 * (1 + std::abs(value));
}

/// Difference quotients of all derivatives and outputs for a step up, a step down, and both.
struct Slopes {
  double step;
  Eigen::VectorXd above, below, central;

  /// Returns whether the one-sided slopes differ by more than rounding errors, which scale with the values.
  bool Differ(Eigen::Index row, double scale) const {
    const double difference = std::abs(above[row] - below[row]);
    return difference > 1e-3 * std::max(std::abs(above[row]), std::abs(below[row])) &&
           difference > 1e-6 * scale;
  }
  /// Returns whether a value changes over the step as in a jump, and by more than rounding errors.
  bool MayJump(Eigen::Index row, double value, double scale) const {
    return std::abs(central[row]) * step > 1e-3 * std::abs(value) && std::abs(central[row]) > 1e-3 * scale;
  }
};

enum class Smoothness { kSmooth, kKink, kJump };

/// With a tenth of the step, a difference of the slopes due to curvature decreases to a tenth, while that of
/// a kink remains, and that of a kink inside the longer step vanishes. The slope at a jump increases.
Smoothness Judge(const Slopes& slopes, const Slopes& nearer, Eigen::Index row, double value, double scale) {
  if (slopes.MayJump(row, value, scale) && std::abs(nearer.central[row]) > 2 * std::abs(slopes.central[row]))
    return Smoothness::kJump;
  const double ratio = (nearer.above[row] - nearer.below[row]) / (slopes.above[row] - slopes.below[row]);
  const bool kink = std::abs(ratio) < 0.02 || (ratio > 0.5 && ratio < 2);  // otherwise the values are noisy
  return kink && slopes.Differ(row, scale) ? Smoothness::kKink : Smoothness::kSmooth;
}

}  // namespace

LinearModel Linearize(const Context& original, const std::vector<const Source*>& inputs,
                      const std::vector<const Source*>& outputs) {
  if (original.diagram().num_continuous_states() == 0 && original.diagram().has_samples()) {
    throw RunError(
        "Linearize: this diagram has samples but no continuous state, so that it has no continuous dynamics; "
        "use "
        "LinearizeDiscrete, or linearise its plant");
  }
  const std::unique_ptr<Context> context = original.Clone();
  const internal::RealNumbers variables = StatesAnd(inputs, *context);
  const Eigen::VectorXd center = variables.Get(*context);
  const auto evaluate_outputs = [&] { return internal::EvalNumbers(*context, outputs); };
  LinearModel model;
  model.states = context->diagram().ContinuousStateNames();
  model.x0 = context->continuous_state();
  model.u0 = center.tail(center.size() - model.x0.size());
  model.xdot0 = context->EvalTimeDerivatives();
  model.y0 = evaluate_outputs();
  model.inputs.assign(variables.names().begin() + model.x0.size(), variables.names().end());
  model.outputs = internal::NumberNames(*context, outputs);

  const Eigen::Index n = model.x0.size(), m = model.u0.size(), p = model.y0.size();
  Eigen::VectorXd middle(n + p);
  middle << model.xdot0, model.y0;
  const auto values_at = [&](Eigen::Index i, double value) {
    Eigen::VectorXd point = center, values(n + p);
    point[i] = value;
    variables.Set(*context, point);
    values << context->EvalTimeDerivatives(), evaluate_outputs();
    return values;
  };
  Eigen::MatrixXd slopes(n + p, n + m);
  std::vector<Slopes> sides;
  const auto differentiate = [&](Eigen::Index i, double step) -> Slopes {
    const double high = center[i] + step, low = center[i] - step;
    const Eigen::VectorXd above = values_at(i, high), below = values_at(i, low);
    return {step, (above - middle) / (high - center[i]), (middle - below) / (center[i] - low),
            (above - below) / (high - low)};
  };
  for (Eigen::Index i = 0; i < n + m; ++i) {
    sides.push_back(differentiate(i, Step(center[i])));
    slopes.col(i) = sides.back().central;
  }

  const Eigen::VectorXd scales =
      middle.cwiseAbs().cwiseMax(slopes.cwiseAbs() * (1 + center.array().abs()).matrix());
  for (Eigen::Index i = 0; i < n + m; ++i) {
    const Slopes& side = sides[static_cast<std::size_t>(i)];
    std::optional<Slopes> nearer;
    for (Eigen::Index row = 0; row < n + p; ++row) {
      if (!side.Differ(row, scales[row]) && !side.MayJump(row, middle[row], scales[row])) continue;
      if (!nearer) nearer = differentiate(i, side.step / 10);
      const Smoothness smoothness = Judge(side, *nearer, row, middle[row], scales[row]);
      if (smoothness == Smoothness::kSmooth) continue;
      const auto name = [](const std::vector<std::string>& names, Eigen::Index k) {
        return "'" + names[static_cast<std::size_t>(k)] + "'";
      };
      const std::string moved = i < n ? name(model.states, i) : name(model.inputs, i - n);
      throw RunError(fmt::format(
          "Linearize: {} has no derivative with respect to {} at {}: {}. Linearise beside that point: move "
          "{} "
          "by more than {:.3g} to the side that counts",
          row < n ? "d/dt of " + name(model.states, row) : name(model.outputs, row - n), moved, center[i],
          smoothness == Smoothness::kJump
              ? std::string("it jumps")
              : fmt::format("its slope is {:.6g} above and {:.6g} below", side.above[row], side.below[row]),
          moved, side.step));
    }
  }
  model.A = slopes.topLeftCorner(n, n);
  model.B = slopes.topRightCorner(n, m);
  model.C = slopes.bottomLeftCorner(p, n);
  model.D = slopes.bottomRightCorner(p, m);
  return model;
}

void FindEquilibrium(Context& context, const EquilibriumOptions& options) {
  struct Residual {
    Context& context;
    const internal::RealNumbers& variables;
    int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
      variables.Set(context, x);
      f.setZero();
      const Eigen::VectorXd derivatives = context.EvalTimeDerivatives();
      f.head(derivatives.size()) = derivatives;
      return 0;
    }
    int df(const Eigen::VectorXd& x, Eigen::MatrixXd& jacobian) const {
      Eigen::VectorXd above(values()), below(values());
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        Eigen::VectorXd point = x;
        point[i] = x[i] + Step(x[i]);
        const double end = point[i];
        (*this)(point, above);
        point[i] = x[i] - Step(x[i]);
        (*this)(point, below);
        jacobian.col(i) = (above - below) / (end - point[i]);
      }
      return 0;
    }
    // The method requires at least as many equations as unknowns, so trim adds equations 0 = 0.
    int values() const { return inputs(); }
    int inputs() const { return static_cast<int>(variables.size()); }
  };
  const internal::RealNumbers variables = StatesAnd(options.free_inputs, context);
  Eigen::VectorXd x = variables.Get(context);
  if (x.size() == 0) return;
  Residual residual{context, variables};
  Eigen::LevenbergMarquardt<Residual> solver(residual);
  solver.parameters.xtol = 1e-15;
  solver.parameters.ftol = 1e-15;
  solver.parameters.maxfev = options.max_iterations;
  solver.minimize(x);
  variables.Set(context, x);

  const Eigen::VectorXd derivatives = context.EvalTimeDerivatives();
  if (derivatives.norm() <= options.tolerance) return;
  Eigen::Index worst = 0;
  derivatives.cwiseAbs().maxCoeff(&worst);
  throw RunError(
      fmt::format("no equilibrium found near the given values: d/dt of '{}' stays at {:.3g}, |xdot| = {:.3g} "
                  "is above {:g}. Start "
                  "nearer, or let inputs go free",
                  context.diagram().ContinuousStateNames()[static_cast<std::size_t>(worst)],
                  derivatives[worst], derivatives.norm(), options.tolerance));
}

SensitivityResult Sensitivity(const Context& context, const std::vector<const Source*>& sources,
                              const Figure& figure, const SensitivityOptions& options) {
  if (!(options.step > 0)) throw ParameterError(fmt::format("step {} must be positive", options.step));
  for (const auto& [unit, scale] : options.scales) {
    if (!(scale > 0)) throw ParameterError(fmt::format("scale {} of '{}' must be positive", scale, unit));
  }
  for (const Source* source : sources) {
    if (internal::RealNumbers(context, {source}).size() > 0) continue;
    throw RunError(fmt::format("'{}' holds no real number and has no derivative; omit it", source->path()));
  }
  const internal::RealNumbers numbers(context, sources);
  const Eigen::VectorXd origin = numbers.Get(*context.Clone());
  const auto run = [&](const Eigen::VectorXd& at, const std::string& what) {
    double value = 0;
    try {
      std::unique_ptr<Context> start = context.Clone();
      numbers.Set(*start, at);
      value = figure(std::move(start));
    } catch (const Error& error) {
      std::throw_with_nested(RunError(fmt::format("{}: {}", what, error.what())));
    }
    if (!std::isfinite(value)) throw RunError(fmt::format("{}: the figure is {}", what, value));
    return value;
  };

  SensitivityResult result;
  result.names = numbers.names();
  result.units = numbers.units();
  result.figure = run(origin, "in the nominal run");
  result.gradient.resize(origin.size());
  for (Eigen::Index i = 0; i < origin.size(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    const auto found = options.scales.find(result.units[index]);
    const double own = origin[i] != 0 ? std::abs(origin[i]) : 1;
    const double step = options.step * (found != options.scales.end() ? found->second : own);
    const auto run_at = [&](double value) {
      Eigen::VectorXd at = origin;
      at[i] = value;
      return run(at, fmt::format("with '{}' moved to {}", result.names[index], value));
    };
    const double high = origin[i] + step, low = origin[i] - step;
    result.gradient[i] = (run_at(high) - run_at(low)) / (high - low);
  }
  return result;
}

}  // namespace tenon

namespace tenon::internal {

std::vector<std::string> NumberNames(const Context& context, const std::vector<const Source*>& sources) {
  std::vector<std::string> names;
  for (const Source* source : sources) {
    for (const Element& element : context.Elements(*source)) names.push_back(element.PathIn(source->path()));
  }
  return names;
}

Eigen::VectorXd EvalNumbers(Context& context, const std::vector<const Source*>& sources) {
  std::vector<double> values;
  for (const Source* source : sources) {
    const std::vector<double> own = context.EvalDoubles(*source);
    values.insert(values.end(), own.begin(), own.end());
  }
  return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

RealNumbers::RealNumbers(const Context& context, std::vector<const Source*> sources) {
  for (const Source* source : sources) {
    Part part{source, {}};
    for (const Element& element : context.Elements(*source)) {
      part.is_real.push_back(element.is_real);
      if (!element.is_real) continue;
      names_.push_back(element.PathIn(source->path()));
      units_.push_back(element.unit);
    }
    parts_.push_back(std::move(part));
  }
}

std::vector<double> RealNumbers::Eval(Context& context, const Part& part) const {
  std::vector<double> values = context.EvalDoubles(*part.source);
  if (values.size() == part.is_real.size()) return values;
  throw RunError(
      fmt::format("'{}' holds {} numbers at t = {} s, but held {} before: signals of variable size have no "
                  "derivative, omit it",
                  part.source->path(), values.size(), context.time(), part.is_real.size()));
}

Eigen::VectorXd RealNumbers::Get(Context& context) const {
  Eigen::VectorXd all(size());
  Eigen::Index next = 0;
  for (const Part& part : parts_) {
    const std::vector<double> values = Eval(context, part);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (part.is_real[i]) all[next++] = values[i];
    }
  }
  return all;
}

void RealNumbers::Set(Context& context, const Eigen::VectorXd& all) const {
  Eigen::Index next = 0;
  for (const Part& part : parts_) {
    std::vector<double> values = Eval(context, part);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (part.is_real[i]) values[i] = all[next++];
    }
    context.SetDoubles(*part.source, values);
  }
}

}  // namespace tenon::internal
