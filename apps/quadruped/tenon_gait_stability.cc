// tenon-gait-stability: the Floquet multipliers of a walking robot.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/systems/analysis/linearize_discrete.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <fmt/core.h>

#include <numeric>

namespace tenon::apps {
namespace {

struct GaitStabilityOptions {
  int settle = 20;                  ///< strides before the linearized one
  int strides = 8;                  ///< strides over which the decay of a push is compared
  double push = 0.005;              ///< change of the trunk's velocity to the left [m/s]
  std::vector<double> steps{1e-5};  ///< step sizes of the finite differences
};

constexpr std::size_t kShown = 12;  // number of multipliers that are printed
constexpr double kNeutral = 1e-3;   // distance from 1 up to which a multiplier counts as neutral
constexpr double kMargin = 1;       // time after the last change of speed [s]

/// The walk of a scenario without disturbances and faults, whose last walking segment is extended without
/// end.
QuadrupedWalkParams EndlessWalk(const QuadrupedScenario& scenario) {
  if (!scenario.walk)
    throw ParameterError("this scenario does not walk: choose one that walks, such as flat");
  QuadrupedWalkParams params = MakeWalkParams(scenario);
  std::vector<WalkSegment>& segments = params.walk.segments;
  while (!segments.empty() && segments.back().gait == Gait::kStand) segments.pop_back();
  if (segments.empty()) throw KeyError("walk.path.segments", "no segment walks: add one");
  if (segments.back().yaw_rate != 0)
    throw KeyError("walk.path.segments",
                   "the last walking segment turns, but only a straight walk can be analysed");
  segments.back().length.reset();
  segments.back().duration = 1e4;
  params.world.pulses.clear();
  params.world.sines.clear();
  params.world.random.clear();
  return params;
}

/// The deviation of the robot's state from a nominal one, without position and heading, which are neutral.
Eigen::VectorXd Deviation(const LeggedState& x, const LeggedState& nominal) {
  Eigen::VectorXd deviation(1 + 2 + 6 + 24);
  deviation << x.p_WB[2] - nominal.p_WB[2], (x.q_WB - nominal.q_WB).segment<2>(1), x.v_W - nominal.v_W,
      x.w_W - nominal.w_W, x.q - nominal.q, x.qd - nominal.qd;
  return deviation;
}

/// Prints the largest multipliers. States that the gait never writes are left out: each of them adds a
/// multiplier of exactly 1.
void PrintMultipliers(const DiscreteLinearModel& map) {
  std::vector<Eigen::Index> alive;
  for (Eigen::Index i = 0; i < map.A.rows(); ++i) {
    if (map.A.row(i) != Eigen::RowVectorXd::Unit(map.A.cols(), i)) alive.push_back(i);
  }
  const Eigen::MatrixXd A = map.A(alive, alive);
  const Eigen::VectorXcd multipliers = Eigenvalues(A);
  std::vector<Eigen::Index> order(alive.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return std::abs(multipliers[a]) > std::abs(multipliers[b]); });
  fmt::print("{} states, of which the gait changes {}; {} flips\n", map.A.rows(), alive.size(),
             map.flips.size());
  fmt::print("multipliers, the largest first:\n");
  for (std::size_t i = 0; i < std::min(order.size(), kShown); ++i) {
    const std::complex<double> value = multipliers[order[i]];
    const bool neutral = std::abs(value - 1.0) < kNeutral;
    fmt::print("  |{:.4f}|  {:8.4f} {:+8.4f}i{}\n", std::abs(value), value.real(), value.imag(),
               neutral ? "  neutral: place and heading" : "");
  }
}

/// The motion that the linear model predicts from the deviation `dx` of all states and a nominal run.
LeggedState Predict(const DiscreteLinearModel& map, const Eigen::VectorXd& dx, Context& nominal,
                    const QuadrupedPlant& plant) {
  std::vector<double> numbers = nominal.EvalDoubles(plant.motion);
  const std::vector<Element> elements = nominal.Elements(plant.motion);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const auto state =
        std::find(map.states.begin(), map.states.end(), plant.motion.path() + "." + elements[i].name);
    numbers[i] += dx[state - map.states.begin()];
  }
  const auto scratch = nominal.Clone();
  scratch->SetDoubles(plant.motion, numbers);
  return scratch->Eval(plant.motion);
}

/// Prints the deviation of the robot after a push, stride by stride, in simulation and by the linear model.
void ComparePush(const DiscreteLinearModel& map, const Context& at_begin, const QuadrupedPlant& plant,
                 const SimulatorOptions& simulation, const GaitStabilityOptions& options) {
  const std::string pushed = plant.motion.path() + ".v_W.y";
  const auto found = std::find(map.states.begin(), map.states.end(), pushed);
  if (found == map.states.end()) throw RunError(fmt::format("'{}' is not a state of the stride map", pushed));
  Eigen::VectorXd dx = Eigen::VectorXd::Zero(map.A.rows());
  dx[found - map.states.begin()] = options.push;
  auto perturbed = at_begin.Clone();
  LeggedState motion = perturbed->Eval(plant.motion);
  motion.v_W[1] += options.push;
  perturbed->Set(plant.motion, motion);
  Simulator with(std::move(perturbed), simulation), without(at_begin.Clone(), simulation);
  fmt::print(
      "a push of {} m/s: deviation of the robot after each stride\n  stride  simulated predicted    error\n",
      options.push);
  for (int k = 1; k <= options.strides; ++k) {
    const double t = map.time + k * map.period;
    if (with.AdvanceToBefore(t).ended || without.AdvanceToBefore(t).ended) throw RunError("the robot fell");
    dx = map.A * dx;
    const LeggedState nominal = without.context().Eval(plant.motion);
    const Eigen::VectorXd simulated = Deviation(with.context().Eval(plant.motion), nominal),
                          linear = Deviation(Predict(map, dx, without.context(), plant), nominal);
    fmt::print("  {:>6}  {:>9.3e}  {:>9.3e}  {:>5.1f} %\n", k, simulated.norm(), linear.norm(),
               100 * (simulated - linear).norm() / simulated.norm());
  }
}

int Analyse(const QuadrupedScenario& scenario, const std::string& name, const GaitStabilityOptions& options) {
  const QuadrupedWalkParams params = Blame("", [&] { return EndlessWalk(scenario); });
  const WalkSegment& last = params.walk.segments.back();
  const double period = params.locomotion.scheduler.gaits[last.gait].Timing().cycle();

  DiagramBuilder builder;
  const auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  const SimulatorOptions simulation = MakeSimulatorOptions(scenario, loop.world.plant);
  Simulator simulator(builder.Build(), simulation);
  const double begin = period * (std::ceil((loop.walk.last_ramp_end() + kMargin) / period) + options.settle);
  if (const RunStatus status = simulator.AdvanceToBefore(begin); status.ended) throw RunError(status.reason);
  const auto at_begin = simulator.context().Clone();
  fmt::print("{}: {} at {:.3g} m/s, period {:.3g} s, from t = {:.4g} s\n", name, EnumName(last.gait),
             last.forward, period, begin);

  LinearizeDiscreteOptions linearization;
  linearization.period = period;
  linearization.steps = options.steps;
  linearization.simulator = simulation;
  // The gait clock jumps when it is perturbed by less than a tick.
  linearization.left_out = {&loop.locomotion.scheduler.memory};
  const DiscreteLinearModel map = LinearizeDiscrete(*at_begin, {}, {&loop.world.state}, linearization);
  PrintMultipliers(map);
  ComparePush(map, *at_begin, loop.world.plant, simulation, options);
  return kRan;
}

/// Linearizes the stride of a walking robot without disturbances. Prints the Floquet multipliers, the
/// eigenvalues of the stride map, and compares the decay of a small push in the linear model with the
/// simulation. `name` is printed as that of the scenario. Returns the exit code. Throws ParameterError with
/// the place of a value that is not possible, and RunError if the robot falls.
int StudyGaitStability(const YamlDocument& document, const std::string& name,
                       const GaitStabilityOptions& options) {
  const auto scenario = document.Read<QuadrupedScenario>();
  return RunBlaming(document, [&] { return Analyse(scenario, name, options); });
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  using namespace tenon::apps;
  CommandLine line("Linearises the stride of a walking quadruped and prints its Floquet multipliers.",
                   "tenon-gait-stability");
  CommonArguments arguments;
  AddScenarioArguments(line, arguments);
  line.SetFooter(
      "Writes no files: all results are printed. The last segment of the walk is extended without end, and\n"
      "disturbances are removed.\n"
      "Exit codes: 0 analysed; 2 bad usage or scenario; 4 the robot fell, or numerical failure.");
  GaitStabilityOptions options;
  line.Add("--settle", &options.settle, "number of strides before the one that is linearised",
           {.range = OptionRange::kNotNegative});
  line.Add("--strides", &options.strides, "number of strides over which the decay of a push is compared",
           {.range = OptionRange::kPositiveInteger});
  line.Add("--push", &options.push, "change of the trunk's velocity to the left [m/s]");
  line.Add("--steps", &options.steps, "step sizes of the finite differences");
  return RunMain(line, argc, argv, [&]() -> int {
    const ScenarioApp app = QuadrupedApp().AsScenarioApp();
    if (PrintsInstead(arguments, app)) return kRan;
    return StudyGaitStability(LoadScenario(arguments, app.name), arguments.scenario, options);
  });
}
