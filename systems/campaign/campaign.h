#pragma once

#include <tenon/systems/simulation/simulator.h>

namespace tenon {

/// The figures of one run of a campaign, or the reason why it failed.
template <class Figures>
struct CampaignRun {
  std::uint64_t seed = 0;
  std::optional<Figures> figures{};
  std::string failure{};  ///< message of the exception that the run threw
};

/// Calls work(k) for k = 0 … count - 1 in `jobs` threads, each of which takes the next k when it is free.
/// After an exception of `work`, running calls are finished, no others are started, and the first exception
/// is rethrown. Throws ParameterError unless jobs is positive.
void ForEachRun(std::size_t count, int jobs, const std::function<void(std::size_t)>& work);

/// Runs one diagram `count` times in separate contexts, `jobs` at a time. The result of a run depends only on
/// its index, not on the number of jobs:
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
/// `vary` sets parameters, inputs and states of a run's new context. `figures` runs it and returns its
/// figures. Both are called by several threads at once. The seed of run k is options.seed + k (1 + k without
/// one). If a run throws, its entry holds the message and the other runs continue.
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
