#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/comparison.h>
#include <tenon/apps/common/progress.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/scenario_app.h>
#include <tenon/apps/common/tally.h>
#include <tenon/apps/studies/observer_order_scenario.h>
#include <tenon/apps/studies/observer_order_study.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

namespace tenon::apps {
namespace {

constexpr double kSettled = 0.02;  // band of the settling time, relative to the force

/// Computes overshoot and settling time of an estimate of a constant force from its log.
class StepFigures final : public LogSink {
 public:
  StepFigures(const LegMomentumObserver& observer, const Eigen::Vector3d& force, double start)
      : observer_(observer), force_(force), start_(start) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override {
    estimate_ = Columns(names, observer_.estimate, &LegForceEstimate::foot_force, &FootForces::front_left);
  }
  void Row(std::span<const double> row) override {
    if (row[0] < start_) return;
    const Eigen::Vector3d estimate(row[estimate_[0]], row[estimate_[1]], row[estimate_[2]]);
    const double share = estimate.dot(force_) / force_.squaredNorm();
    shares_.Add(share);
    const bool inside = std::abs(share - 1) <= kSettled;
    if (inside && !inside_) inside_since_ = row[0];
    inside_ = inside;
  }
  /// Relative to the force; empty if the run ended before the force.
  std::optional<double> overshoot() const {
    if (const auto peak = shares_.max()) return *peak < 1 ? 0 : *peak - 1;
    return std::nullopt;
  }
  /// Time from which the estimate stays in the band [s]; empty if it does not.
  std::optional<double> settling_time() const {
    return inside_ ? std::optional(inside_since_ - start_) : std::nullopt;
  }

 private:
  const LegMomentumObserver& observer_;
  Eigen::Vector3d force_;
  double start_, inside_since_ = 0;
  Tally shares_;  ///< shares of the force that the estimate shows
  bool inside_ = false;
  std::vector<std::size_t> estimate_;
};

/// The two figures of a variant between which there is a trade-off.
struct Cost {
  double settling = std::numeric_limits<double>::infinity();  ///< settling time [s]
  double noise = std::numeric_limits<double>::infinity();     ///< noise bandwidth [Hz]
  bool WorseThan(const Cost& other) const {
    return other.settling <= settling && other.noise <= noise &&
           (other.settling < settling || other.noise < noise);
  }
};

struct Result {
  Summary summary;
  std::optional<Report> report;  ///< empty if the gains were refused
  Cost cost;
  std::optional<double> overshoot = std::nullopt;
  double lag = 0;
};

Report MakeReport(const ObserverOrderScenario& scenario) {
  return ScenarioReport(scenario,
                        fmt::format("{} stands; {:.4g} N on its front left foot from {} s on",
                                    ResourceName(scenario.robot), scenario.force_N.norm(), scenario.start_s));
}

void Connect(DiagramBuilder& builder, QuadrupedWorld& world, JointPd& pd, LegMomentumObserver& observer) {
  builder.Connect(world.joints, pd.joints);
  builder.Connect(pd.torque, world.torque);
  builder.Connect(world.state, observer.state);
  builder.Connect(pd.torque, observer.torque);
  builder.Connect(world.foot_forces, observer.foot_forces);
}

QuadrupedWorldParams MakeWorld(const ObserverOrderScenario& scenario) {
  QuadrupedWorldParams world;
  world.plant.robot = Blame("robot", [&] { return LoadQuadruped(scenario.robot); });
  world.plant.initial.p_WB[2] = world.plant.robot.StanceHeight();
  world.plant.initial.q = world.plant.robot.stance;
  world.min_height = 0.5 * world.plant.robot.StanceHeight();
  PulseForceParams push;
  push.push = PointOnLeg(world.plant.robot, 0, 0);
  push.push.force_W = scenario.force_N;
  push.start = scenario.start_s;
  push.duration = scenario.duration_s;
  world.pulses.push_back(push);
  return world;
}

/// The result of a variant whose gains are refused with the message `why`.
Result Refused(const ObserverOrderScenario& scenario, const VariantScenario& variant, const char* why) {
  RunOutcome outcome;
  outcome.failure = fmt::format("refused: {}", why);
  outcome.exit_code = kNumericalFailure;
  Result result{Summary(scenario.case_name, scenario.seed, outcome), std::nullopt, Cost()};
  result.summary.Set("gains_per_s", fmt::format("{:.4g}", fmt::join(variant.gains_per_s, ", ")));
  result.summary.Set("order", static_cast<double>(variant.gains_per_s.size()));
  result.summary.Set("stable", std::string("no"));
  return result;
}

LegMomentumObserverParams ObserverOf(const QuadrupedDescription& robot, const VariantScenario& variant) {
  LegMomentumObserverParams params;
  params.robot = robot;
  params.gains.gains = variant.gains_per_s;
  params.Validate();
  return params;
}

/// Throws KeyError if the gains of all variants are refused.
void DemandValidVariant(const ObserverOrderScenario& scenario) {
  const QuadrupedDescription robot = MakeWorld(scenario).plant.robot;
  std::string why;
  for (const VariantScenario& variant : scenario.variants) {
    try {
      ObserverOf(robot, variant);
      return;
    } catch (const ParameterError& error) {
      if (why.empty()) why = error.what();
    }
  }
  throw KeyError("variants", fmt::format("0: {}", why));
}

Result RunVariant(const RunOptions& options, ObserverOrderScenario scenario, const VariantScenario& variant) {
  const QuadrupedWorldParams world_params = MakeWorld(scenario);
  LegMomentumObserverParams observer_params;
  try {
    observer_params = ObserverOf(world_params.plant.robot, variant);
  } catch (const ParameterError& error) {
    return Refused(scenario, variant, error.what());
  }
  DiagramBuilder builder;
  auto& world = builder.Add<QuadrupedWorld>("world", world_params);
  JointPdParams pd_params = scenario.pd.For(world_params.plant.robot);
  pd_params.gravity = world_params.plant.gravity;
  auto& pd = builder.Add<JointPd>("pd", pd_params);
  auto& observer = builder.Add<LegMomentumObserver>("observer", observer_params);
  Connect(builder, world, pd, observer);
  const auto diagram = builder.Build();

  Simulator simulator(
      *diagram, {.method = Method::kErkOpen, .order = 3, .rtol = 1e-4, .atol = 1e-6, .seed = scenario.seed});
  std::vector<const Source*> signals{&observer.estimate, &world.plant.joint_torque, &world.ground_forces};
  AddRequested(*diagram, scenario, signals);
  Report report = MakeReport(scenario);
  report.Log(simulator, signals, {&world.plant.geometry});
  scenario.variants = {variant};
  const ScenarioFiles files(scenario);
  const OutputDirectory out(options.out);
  files.Write(out.path());
  WriteGraph(*diagram, options.graph);
  const auto figures = std::make_shared<StepFigures>(observer, scenario.force_N, scenario.start_s);
  simulator.AddLog(Hz(1000), signals, {figures, std::make_shared<ProgressSink>(scenario.duration_s)});
  simulator.AddLog(Hz(scenario.log_rate_hz), signals, {std::make_shared<CsvLog>(out.path() / "signals.csv")});
  const RunOutcome outcome = Advance(simulator, scenario.duration_s);

  Result result{Summary(scenario.case_name, scenario.seed, outcome), std::move(report), Cost()};
  result.cost = {figures->settling_time().value_or(std::numeric_limits<double>::infinity()),
                 NoiseBandwidth(variant.gains_per_s)};
  result.overshoot = figures->overshoot();
  result.lag = 1 / variant.gains_per_s.front();
  Summary& summary = result.summary;
  summary.SetFell(world.monitor.fall);
  summary.Set("gains_per_s", fmt::format("{:.4g}", fmt::join(variant.gains_per_s, ", ")));
  summary.Set("order", static_cast<double>(variant.gains_per_s.size()));
  summary.Set("stable", std::string("yes"));
  summary.Set("settling_time_s", figures->settling_time());
  summary.Set("overshoot_ratio", result.overshoot);
  summary.Set("noise_bandwidth_Hz", result.cost.noise);
  summary.Set("lag_s", result.lag);
  return result;
}

int RunAll(const RunOptions& options, const ObserverOrderScenario& scenario) {
  std::vector<std::string> names;
  for (const VariantScenario& variant : scenario.variants) names.push_back(variant.name);
  CheckVariantNames(names);
  DemandValidVariant(scenario);
  const ScenarioFiles files(scenario);
  const OutputDirectory out(options.out);
  const std::filesystem::path& base = out.path();
  for (const std::string& name : names)
    OutputDirectory(base / name);  // clears those of refused variants, too
  files.Write(base);
  std::vector<Result> results;
  for (const VariantScenario& variant : scenario.variants) {
    RunOptions each = options;
    each.out = base / variant.name;
    results.push_back(RunVariant(each, scenario, variant));
    if (results.back().summary.exit_code() >= kOutputFailed) break;
  }

  Report comparison = MakeReport(scenario);
  Summary::Named runs;
  int worst = kRan;
  fmt::print("{:<20} {:>6} {:>12} {:>10} {:>9} {:>8} {:>9}\n", "", "order", "settling ms", "overshoot",
             "noise Hz", "lag ms", "on front");
  for (std::size_t i = 0; i < results.size(); ++i) {
    Result& result = results[i];
    const VariantScenario& variant = scenario.variants[i];
    int code = kRan;
    if (result.report) {
      const bool front = std::none_of(results.begin(), results.end(),
                                      [&](const Result& other) { return result.cost.WorseThan(other.cost); });
      result.summary.Set("on_front", std::string(front ? "yes" : "no"));
      WriteResults(base / variant.name, result.summary, *result.report);
      comparison.Add(variant.name, *result.report);
      code = result.summary.exit_code();
      fmt::print("{:<20} {:>6} {:>12.1f} {:>10} {:>9.2f} {:>8.1f} {:>9}\n", variant.name,
                 variant.gains_per_s.size(), 1000 * result.cost.settling,
                 result.overshoot ? fmt::format("{:.1f}%", 100 * *result.overshoot) : "-", result.cost.noise,
                 1000 * result.lag, front ? "yes" : "no");
    } else {
      fmt::print("{:<20} {:>6} refused: unstable\n", variant.name, variant.gains_per_s.size());
      code = TryToWrite([&] { result.summary.Write(base / variant.name / "summary.json"); });
    }
    worst = std::max(worst, code);
    runs.emplace_back(variant.name, std::move(result.summary));
  }
  worst = std::max(worst, TryToWrite([&] { Summary::WriteComparison(runs, base / "summary.json"); }));
  worst = std::max(worst, TryToWrite([&] { comparison.Write(base / "report.html"); }));
  PrintReportPath(base);
  return worst;
}

}  // namespace

ScenarioApp ObserverOrderApp() {
  return {.name = "tenon-observer-order",
          .description = {},
          .keys = [] { return KeysOf<ObserverOrderScenario>(); },
          .check = {},
          .run = {}};
}

int StudyObserverOrders(const YamlDocument& document, std::optional<double> duration,
                        const RunOptions& options) {
  auto scenario = document.Read<ObserverOrderScenario>();
  if (duration) scenario.duration_s = *duration;
  scenario.Validate();
  return RunBlaming(document, [&] {
    for (std::size_t i = 0; i < scenario.variants.size(); ++i)
      Blame(fmt::format("variants.{}", i), [&] { scenario.variants[i].Resolve(); });
    return RunAll(options, scenario);
  });
}

}  // namespace tenon::apps
