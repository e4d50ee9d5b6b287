// tenon-tune-pd: finds the gains of the cable robot's length controller by optimisation, see
// docs/pd_gains.md.

#include <fmt/core.h>

#include <cmath>
#include <csignal>
#include <nlopt.hpp>

#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/progress.h>
#include <tenon/plants/model/resources.h>

namespace tenon::apps {
namespace {

/// One of the motions that the gains are judged on.
struct Trial {
  CdprScenario scenario;
  double settle_from;  ///< [s]
};

CdprScenario Base(const std::string& robot) {
  CdprScenario scenario;
  scenario.app = "tenon-cdpr";
  scenario.case_name = "tuning";
  scenario.robot = robot;
  scenario.duration_s = 16;
  scenario.forbid_slack = false;
  scenario.path.kind = PathKind::kSpline;
  if (LoadCdpr(FindResource("robots", robot)).num_cables() >= 6) scenario.path.attitude_rad.emplace(0, 0, 0);
  return scenario;
}

/// A fast straight move, a bent one, and the release of a weight. None is a reference that results are shown
/// on.
std::vector<Trial> MakeTrials(const std::string& robot) {
  std::vector<Trial> trials(3, {Base(robot), 4});
  trials[0].scenario.path.points_m = {{-0.6, -0.8, 1.5}, {0.7, 0.6, 2.2}};
  trials[0].scenario.path.times_s = {0, 4};
  trials[1].scenario.path.points_m = {{0.8, -0.5, 1.8}, {0.2, 0.6, 1.4}, {-0.7, 0.2, 2.0}};
  trials[1].scenario.path.times_s = {0, 2.5, 5};
  trials[1].settle_from = 5;
  trials[2].scenario.path.kind = PathKind::kHold;
  trials[2].scenario.path.points_m = {{0.5, 0.9, 1.7}};
  trials[2].scenario.payload = {.mass_kg = 3, .position_m = {0.1, -0.2, -0.1}, .attach_s = 0, .release_s = 4};
  return trials;
}

struct Judgement {
  double tracking_error_rms = 0;  ///< mean over the trials [m]
  double settling_time = 0;       ///< mean over the trials [s]
  double tension_rate_rms = 0;    ///< mean over the trials [N/s]
  /// One centimetre of error weighs as much as one second of settling, and as 100 N/s of rattling cables:
  /// without that term the gains end where the loop is about to become unstable.
  double cost() const { return tracking_error_rms / 0.01 + settling_time + tension_rate_rms / 100; }
};

Judgement Judge(const std::vector<Trial>& trials, double stiffness, double damping) {
  Judgement judgement;
  for (Trial trial : trials) {
    trial.scenario.pd.stiffness_N_per_m = stiffness;
    trial.scenario.pd.damping_N_s_per_m = damping;
    DiagramBuilder builder;
    auto& loop = builder.Add<CdprLoop>("loop", MakeLoopParams(trial.scenario));
    const auto diagram = builder.Build();
    Simulator simulator(*diagram, MakeSimulatorOptions(trial.scenario));
    const auto figures = std::make_shared<CdprFigures>(trial.settle_from, trial.settle_from);
    simulator.AddLog(Hz(trial.scenario.pd.rate_hz), CdprFigures::Signals(loop), {figures});
    const RunOutcome outcome = Advance(simulator, trial.scenario.duration_s);
    if (outcome.exit_code > 128)
      std::raise(outcome.exit_code - 128);  // nothing is written that could be lost
    const double missing = trial.scenario.duration_s - trial.settle_from;
    const bool failed = outcome.status.ended || !outcome.failure.empty();
    judgement.tracking_error_rms += (failed ? 1 : *figures->tracking_error().rms()) / trials.size();
    judgement.tension_rate_rms += (failed ? 1000 : *figures->tension_rate().rms()) / trials.size();
    judgement.settling_time +=
        (failed ? missing : figures->settling_time().value_or(missing)) / trials.size();
  }
  return judgement;
}

double Cost(const std::vector<double>& log_gains, std::vector<double>&, void* trials) {
  const double stiffness = std::exp(log_gains[0]), damping = std::exp(log_gains[1]);
  const Judgement judgement = Judge(*static_cast<const std::vector<Trial>*>(trials), stiffness, damping);
  fmt::print("{:10.1f} {:10.1f} {:12.4f} {:12.3f} {:10.1f} {:8.3f}\n", stiffness, damping,
             judgement.tracking_error_rms, judgement.settling_time, judgement.tension_rate_rms,
             judgement.cost());
  std::fflush(stdout);
  return judgement.cost();
}

int Tune(const std::string& robot, int evaluations) {
  std::vector<Trial> trials = MakeTrials(robot);
  fmt::print("{:>10} {:>10} {:>12} {:>12} {:>10} {:>8}\n", "K_p N/m", "K_d N s/m", "error rms m",
             "settling s", "rate N/s", "cost");
  nlopt::opt search(nlopt::LN_BOBYQA, 2);
  search.set_lower_bounds({std::log(50), std::log(5)});
  search.set_upper_bounds({std::log(8000), std::log(1500)});
  search.set_initial_step(0.7);
  search.set_maxeval(evaluations);
  search.set_xtol_abs(0.02);
  search.set_min_objective(Cost, &trials);
  std::vector<double> best{std::log(800), std::log(120)};
  double cost = 0;
  search.optimize(best, cost);
  fmt::print("best: stiffness_N_per_m: {:.0f}, damping_N_s_per_m: {:.0f} (cost {:.3f})\n", std::exp(best[0]),
             std::exp(best[1]), cost);
  return kRan;
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Finds gains of the cable robot's length controller by optimisation.", "tenon-tune-pd");
  std::string robot = "cdpr_4";
  int evaluations = 60;
  app.add_option("--robot", robot, "a shipped robot or a YAML file")->capture_default_str();
  app.add_option("--evaluations", evaluations, "at most so many trials of gains")->capture_default_str();
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Tune(robot, evaluations); });
}
