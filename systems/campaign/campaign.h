#pragma once

#include <tenon/systems/simulation/simulator.h>

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace tenon {

/// What became of one run of a campaign: its figures, or why it has none.
template <class Figures>
struct CampaignRun {
  std::uint64_t seed = 0;
  std::optional<Figures> figures{};
  std::string failure{};  ///< what() of what the run threw
};

/// Calls work(k) for k = 0 … count - 1, in `jobs` threads at a time; whoever is free takes the next. The
/// first exception that `work` throws ends it: what runs is finished, the rest is left, and it is thrown.
/// Throws ParameterError unless jobs is positive.
void ForEachRun(std::size_t count, int jobs, const std::function<void(std::size_t)>& work);

/// Runs one diagram `count` times, each time in a context of its own, `jobs` at a time. What a run computes
/// follows from its index alone, so the result is the same for any number of jobs:
///
///     const auto runs = RunCampaign(
///         *diagram, 1000, 2,
///         [&](std::size_t run, Context& context) {
///           RandomStream random(run, "mass");
///           context.Set(cart.mass, random.Uniform(1, 3));
///         },
///         [&](Simulator& simulator) {
///           simulator.RunTo(10);
///           return simulator.context().Eval(cart.position);
///         });
///
/// `vary` makes of a fresh context that of a run: it sets parameters, inputs, states. `figures` runs it and
/// returns what is to be known of it. Both are called by several threads at once. The seed of run k is
/// options.seed + k (1 + k without one). What a run throws is kept in its place, the others go on.
template <class Vary, class Figures>
auto RunCampaign(const Diagram& diagram, std::size_t count, int jobs, const Vary& vary,
                 const Figures& figures, const SimulatorOptions& options = {}) {
  using Result = std::decay_t<std::invoke_result_t<const Figures&, Simulator&>>;
  std::vector<CampaignRun<Result>> runs(count);
  ForEachRun(count, jobs, [&](std::size_t k) {
    SimulatorOptions own = options;
    own.seed = options.seed.value_or(1) + k;
    runs[k].seed = *own.seed;
    try {
      Simulator simulator(diagram, own);
      vary(k, simulator.context());
      runs[k].figures = figures(simulator);
    } catch (const std::exception& error) {
      runs[k].failure = error.what();
    }
  });
  return runs;
}

}  // namespace tenon
