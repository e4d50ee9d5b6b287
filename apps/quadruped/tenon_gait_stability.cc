// tenon-gait-stability: the Floquet multipliers of a walking robot, and whether they foretell how a push
// decays.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/systems/analysis/linearize_discrete.h>

#include <Eigen/Eigenvalues>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

namespace tenon::apps {
namespace {

constexpr std::size_t kShown = 12;
constexpr double kNeutral = 1e-3;  // so near to 1
constexpr double kMore = 1;        // after it has its speed [s]

struct StabilityArguments {
  int settle = 20;      ///< strides before
  int strides = 8;      ///< of the push's decay
  double push = 0.005;  ///< of the trunk, to the left [m/s]
  std::vector<double> steps = {1e-5};
};

/// The walk of a scenario for ever: undisturbed, without faults, and its last segment that walks goes on.
QuadrupedWalkParams EndlessWalk(const QuadrupedScenario& scenario) {
  if (!scenario.walk) throw ParameterError("this scenario does not walk: take one that does, flat say");
  QuadrupedWalkParams params = MakeWalkParams(scenario);
  std::vector<WalkSegment>& segments = params.walk.segments;
  while (!segments.empty() && segments.back().gait == Gait::kStand) segments.pop_back();
  if (segments.empty()) throw KeyError("walk.path.segments", "none of them walks");
  if (segments.back().yaw_rate != 0)
    throw KeyError("walk.path.segments", "the last one turns, but what is analysed goes straight on");
  segments.back().length.reset();
  segments.back().duration = 1e4;
  params.world.pulses.clear();
  params.world.sines.clear();
  params.world.random.clear();
  return params;
}

/// Trunk's height, attitude and velocities, joints: what a push shows in, place and heading left out.
Eigen::VectorXd Deviation(const LeggedState& x, const LeggedState& nominal) {
  Eigen::VectorXd deviation(1 + 2 + 6 + 24);
  deviation << x.p_WB[2] - nominal.p_WB[2], (x.q_WB - nominal.q_WB).segment<2>(1), x.v_W - nominal.v_W,
      x.w_W - nominal.w_W, x.q - nominal.q, x.qd - nominal.qd;
  return deviation;
}

/// Leaves out memory that the gait never writes, which adds multipliers of exactly 1.
void PrintMultipliers(const DiscreteLinearModel& map) {
  std::vector<Eigen::Index> alive;
  for (Eigen::Index i = 0; i < map.A.rows(); ++i) {
    if (map.A.row(i) != Eigen::RowVectorXd::Unit(map.A.cols(), i)) alive.push_back(i);
  }
  const Eigen::MatrixXd A = map.A(alive, alive);
  const Eigen::VectorXcd multipliers = A.eigenvalues();
  std::vector<Eigen::Index> order(alive.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return std::abs(multipliers[a]) > std::abs(multipliers[b]); });
  fmt::print("{} states, of which the gait moves {}; {} flips\n", map.A.rows(), alive.size(),
             map.flips.size());
  fmt::print("multipliers, the largest first:\n");
  for (std::size_t i = 0; i < std::min(order.size(), kShown); ++i) {
    const std::complex<double> value = multipliers[order[i]];
    const bool neutral = std::abs(value - 1.0) < kNeutral;
    fmt::print("  |{:.4f}|  {:8.4f} {:+8.4f}i{}\n", std::abs(value), value.real(), value.imag(),
               neutral ? "  neutral: place and heading" : "");
  }
}

int Analyse(const CommonArguments& common, const StabilityArguments& arguments,
            const QuadrupedScenario& scenario) {
  const QuadrupedWalkParams params = Blame("", [&] { return EndlessWalk(scenario); });
  const SimulatorOptions simulation = MakeSimulatorOptions(scenario);
  const WalkSegment& last = params.walk.segments.back();
  const double period = params.locomotion.scheduler.gaits[last.gait].Timing().cycle();

  DiagramBuilder builder;
  const auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  Simulator simulator(builder.Build(), simulation);
  const double begin = period * (std::ceil((loop.walk.last_ramp_end() + kMore) / period) + arguments.settle);
  if (const RunStatus status = simulator.AdvanceToBefore(begin); status.ended) throw RunError(status.reason);
  const auto at_begin = simulator.context().Clone();

  LinearizeDiscreteOptions options;
  options.period = period;
  options.steps = arguments.steps;
  options.simulator = simulation;
  options.left_out = {
      &loop.locomotion.scheduler.memory};  // the gait clock: moved by less than a tick, it jumps
  fmt::print("{}: {} at {:.3g} m/s, period {:.3g} s, from t = {:.4g} s\n", common.scenario,
             EnumName(last.gait), last.forward, period, begin);
  const DiscreteLinearModel map = LinearizeDiscrete(*at_begin, {}, {&loop.world.state}, options);
  PrintMultipliers(map);

  // A push, in the simulation and by the map.
  const std::string pushed = loop.world.plant.motion.path() + ".v_W.y";
  const auto found = std::find(map.states.begin(), map.states.end(), pushed);
  if (found == map.states.end()) throw RunError(fmt::format("'{}' is not in the map", pushed));
  Eigen::VectorXd dx = Eigen::VectorXd::Zero(map.A.rows());
  dx[found - map.states.begin()] = arguments.push;
  auto other = at_begin->Clone();
  LeggedState motion = other->Eval(loop.world.plant.motion);
  motion.v_W[1] += arguments.push;
  other->Set(loop.world.plant.motion, motion);
  Simulator with(std::move(other), simulation), without(at_begin->Clone(), simulation);
  fmt::print(
      "a push of {} m/s: deviation of the robot after each stride\n  stride  simulated  foretold    error\n",
      arguments.push);
  for (int k = 1; k <= arguments.strides; ++k) {
    const double t = begin + k * period;
    if (with.AdvanceToBefore(t).ended || without.AdvanceToBefore(t).ended) throw RunError("the robot fell");
    dx = map.A * dx;
    const LeggedState nominal = without.context().Eval(loop.world.plant.motion);
    LeggedState foretold = nominal;
    std::vector<double> numbers = without.context().EvalDoubles(loop.world.plant.motion);
    const std::vector<Element> elements = without.context().Elements(loop.world.plant.motion);
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const auto state = std::find(map.states.begin(), map.states.end(),
                                   loop.world.plant.motion.path() + "." + elements[i].name);
      numbers[i] += dx[state - map.states.begin()];
    }
    auto scratch = without.context().Clone();
    scratch->SetDoubles(loop.world.plant.motion, numbers);
    foretold = scratch->Eval(loop.world.plant.motion);
    const Eigen::VectorXd simulated = Deviation(with.context().Eval(loop.world.plant.motion), nominal),
                          linear = Deviation(foretold, nominal);
    fmt::print("  {:>6}  {:>9.3e}  {:>9.3e}  {:>5.1f} %\n", k, simulated.norm(), linear.norm(),
               100 * (simulated - linear).norm() / simulated.norm());
  }
  return kRan;
}

int Run(const CommonArguments& common, const StabilityArguments& arguments) {
  if (PrintsInstead(common, QuadrupedApp())) return kRan;
  const YamlDocument document = LoadScenario(common, "tenon-quadruped");
  const auto scenario = document.Read<QuadrupedScenario>();
  return RunBlaming(document, [&] { return Analyse(common, arguments, scenario); });
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Linearises the stride of a walking quadruped and prints its Floquet multipliers.",
               "tenon-gait-stability");
  tenon::apps::CommonArguments arguments;
  tenon::apps::AddScenarioArguments(app, arguments);
  app.footer(
      "Writes no files: all is printed. The last segment of the walk goes on for ever, undisturbed.\n"
      "Exit codes: 0 analysed; 2 bad usage or scenario; 4 the robot fell, or numerical failure.");
  tenon::apps::StabilityArguments stability;
  app.add_option("--settle", stability.settle, "strides before the one that is linearised")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--strides", stability.strides, "for which the decay of a push is compared")
      ->check(tenon::apps::PositiveInteger());
  app.add_option("--push", stability.push, "to the left [m/s]");
  app.add_option("--steps", stability.steps, "of the differences");
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Run(arguments, stability); });
}
