#include <tenon/systems/analysis/internal/numbers.h>
#include <tenon/systems/analysis/sensitivity.h>

#include <fmt/core.h>

#include <exception>

namespace tenon {

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
