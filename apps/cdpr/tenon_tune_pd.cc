// tenon-tune-pd: finds the gains of the cable robot's length controller by optimisation, see
// docs/pd_gains.md.

#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/progress.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>
#include <nlopt.hpp>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <exception>
#include <limits>

namespace tenon::apps {
namespace {

/// One of the motions on which the gains are judged.
struct Trial {
  CdprScenario scenario;
  double settle_from;  ///< [s]
};

/// Size of a robot relative to the one for which the motions below are written.
struct Scale {
  Eigen::Vector3d middle;  ///< centre of the anchors, at the height of the highest anchor [m]
  double length;           ///< mean distance of the anchors from the middle, over that of cdpr_4
  double time;             ///< scale of times by Froude: accelerations remain in proportion to gravity
  double mass;

  explicit Scale(const CdprDescription& robot) : middle(Eigen::Vector3d::Zero()), length(0) {
    const double count = robot.num_cables();
    double top = -std::numeric_limits<double>::infinity();
    for (const CableDescription& cable : robot.cables) {
      middle.head<2>() += cable.anchor_W.head<2>() / count;
      top = std::max(top, cable.anchor_W.z());
    }
    middle.z() = top;
    for (const CableDescription& cable : robot.cables)
      length += (cable.anchor_W - middle).head<2>().norm() / count / std::hypot(3.5, 4.5);
    time = std::sqrt(length);
    mass = robot.mass / 15;
  }
  Eigen::Vector3d Point(double x, double y, double below) const {
    return middle + length * Eigen::Vector3d(x, y, -below);
  }
};

/// A fast straight motion, a curved motion, the release of a payload, and a gust, scaled to the robot. None
/// of these motions occurs in a case with published results.
std::vector<Trial> MakeTrials(const std::string& robot) {
  CdprScenario base;
  base.app = "tenon-cdpr";
  base.case_name = "tuning";
  base.robot = {robot};
  const CdprDescription description = LoadCdpr(base.robot);
  const Scale scale(description);
  base.duration_s = 16 * scale.time;
  base.forbid_slack = false;
  base.path.kind = PathKind::kSpline;
  if (description.num_cables() >= 6) base.path.attitude_rad.emplace(0, 0, 0);
  if (description.num_cables() > 6) base.path.tension_aim_N = 100;  // as in the scenarios
  std::vector<Trial> trials(4, {base, 4 * scale.time});
  trials[0].scenario.path.points_m = {scale.Point(-0.6, -0.8, 2.5), scale.Point(0.7, 0.6, 1.8)};
  trials[0].scenario.path.times_s = {0, 2 * scale.time};
  trials[0].settle_from = 2 * scale.time;
  trials[1].scenario.path.points_m = {scale.Point(0.8, -0.5, 2.2), scale.Point(0.2, 0.6, 2.6),
                                      scale.Point(-0.7, 0.2, 2)};
  trials[1].scenario.path.times_s = {0, 1.5 * scale.time, 3 * scale.time};
  trials[1].settle_from = 3 * scale.time;
  trials[2].scenario.path.kind = PathKind::kHold;
  trials[2].scenario.path.points_m = {scale.Point(0.5, 0.9, 2.3)};
  trials[2].scenario.payload = {.payload = {4 * scale.mass, scale.length * Eigen::Vector3d(0.1, -0.2, 0)},
                                .release_s = 4 * scale.time};
  if (!trials[2]
           .scenario.path.attitude_rad) {  // with four cables the platform can turn with its boom, and swing
    trials[2].scenario.path.points_m = {scale.Point(-0.5, 1.6, 1.3)};
    trials[2].scenario.payload.payload.mass = 5 * scale.mass;
    trials[2].scenario.payload.payload.p_B = scale.length * Eigen::Vector3d(-0.2, -0.9, 0);
  }
  trials[3].scenario.path = trials[2].scenario.path;
  trials[3].scenario.path.points_m = {scale.Point(-0.4, 0.3, 1.9)};
  trials[3].scenario.gusts = {
      {.force_W = scale.mass * Eigen::Vector3d(40, 30, 0), .start = 3 * scale.time, .duration = scale.time}};
  return trials;
}

struct Judgement {
  double tracking_error_rms = 0;  ///< mean over the trials [m]
  double settling_time = 0;       ///< mean over the trials [s]
  double tension_rate_rms = 0;    ///< mean over the trials [N/s]
  std::string failure;            ///< reason of the last trial that failed; empty if none failed
  /// One centimetre of error costs as much as one second of settling, and as 100 N/s of tension rate. Without
  /// the last term the optimum is at the stability limit.
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
    const auto figures = std::make_shared<CdprFigures>(loop, trial.settle_from, trial.settle_from);
    simulator.AddLog(Hz(trial.scenario.pd.rate_hz), CdprFigures::Signals(loop), {figures});
    const RunOutcome outcome = Advance(simulator, trial.scenario.duration_s);
    if (outcome.exit_code > 128)
      std::raise(outcome.exit_code - 128);  // nothing is written that could be lost
    const double missing = trial.scenario.duration_s - trial.settle_from;
    const bool failed = outcome.status.ended || !outcome.failure.empty();
    if (failed) judgement.failure = outcome.failure.empty() ? outcome.status.reason : outcome.failure;
    if (!failed && !figures->settling_time()) judgement.failure = "it does not settle";
    judgement.tracking_error_rms += (failed ? 1 : *figures->tracking_error().rms()) / trials.size();
    judgement.tension_rate_rms += (failed ? 1000 : *figures->tension_rate().rms()) / trials.size();
    judgement.settling_time +=
        (failed ? missing : figures->settling_time().value_or(missing)) / trials.size();
  }
  return judgement;
}

/// State of the search. It stores exceptions, because NLopt does not pass them on.
struct Search {
  std::vector<Trial> trials;
  // The gains with the lowest cost so far.
  double best_cost = std::numeric_limits<double>::infinity();
  double best_stiffness = 0, best_damping = 0;
  std::string best_failure;
  std::exception_ptr error;
};

double Cost(const std::vector<double>& log_gains, std::vector<double>&, void* data) {
  Search& search = *static_cast<Search*>(data);
  const double stiffness = std::exp(log_gains[0]), damping = std::exp(log_gains[1]);
  Judgement judgement;
  try {
    judgement = Judge(search.trials, stiffness, damping);
  } catch (...) {
    search.error = std::current_exception();
    throw nlopt::forced_stop();
  }
  fmt::print("{:10.1f} {:10.1f} {:12.4f} {:12.3f} {:10.1f} {:8.3f}  {}\n", stiffness, damping,
             judgement.tracking_error_rms, judgement.settling_time, judgement.tension_rate_rms,
             judgement.cost(), judgement.failure);
  std::fflush(stdout);
  if (judgement.cost() < search.best_cost) {
    search.best_cost = judgement.cost();
    search.best_stiffness = stiffness;
    search.best_damping = damping;
    search.best_failure = judgement.failure;
  }
  return judgement.cost();
}

int Tune(const std::string& robot, int evaluations) {
  Search search;
  search.trials = MakeTrials(robot);
  fmt::print("{:>10} {:>10} {:>12} {:>12} {:>10} {:>8}\n", "K_p N/m", "K_d N s/m", "error rms m",
             "settling s", "rate N/s", "cost");
  nlopt::opt optimizer(nlopt::LN_BOBYQA, 2);
  optimizer.set_lower_bounds({std::log(50), std::log(5)});
  optimizer.set_upper_bounds({std::log(8000), std::log(1500)});
  optimizer.set_initial_step(0.7);
  optimizer.set_xtol_abs(0.02);
  optimizer.set_min_objective(Cost, &search);
  std::vector<double> start, gradient;
  double cost = std::numeric_limits<double>::infinity();
  try {
    // Starts at the best point of a coarse grid, because some robots are unstable on most of the grid.
    for (const double stiffness : {400, 1500, 5000}) {
      for (const double damping : {60, 200, 600}) {
        if (evaluations-- <= 0) continue;
        const std::vector<double> gains{std::log(stiffness), std::log(damping)};
        const double each = Cost(gains, gradient, &search);
        if (start.empty() || each < cost) start = gains;
        cost = std::min(cost, each);
      }
    }
    optimizer.set_maxeval(evaluations);
    if (evaluations > 0) optimizer.optimize(start, cost);
  } catch (const nlopt::roundoff_limited&) {  // converged to rounding: keep the best so far
  } catch (const nlopt::forced_stop&) {
    if (!search.error) throw;
    std::rethrow_exception(search.error);
  }
  if (!search.best_failure.empty()) {
    Say(fmt::format(
        "tenon-tune-pd: no gains were found that complete all motions; the best ones end with: {}\n",
        search.best_failure));
    return kLimitBroken;
  }
  fmt::print("best: stiffness_N_per_m: {:.0f}, damping_N_s_per_m: {:.0f} (cost {:.3f})\n",
             search.best_stiffness, search.best_damping, search.best_cost);
  return kRan;
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  tenon::apps::CommandLine line("Finds gains of the cable robot's length controller by optimisation.",
                                "tenon-tune-pd");
  std::string robot = "cdpr_4";
  int evaluations = 60;
  line.Add("--robot", &robot, "a shipped robot or a YAML file", {.shows_default = true});
  line.Add("--evaluations", &evaluations, "maximum number of trials of gains",
           {.range = tenon::apps::OptionRange::kPositiveInteger, .shows_default = true});
  line.SetFooter(
      "Writes no files: every trial and the best gains are printed.\n"
      "Exit codes: 0 gains were found; 2 bad usage or robot; 3 no gains complete all motions; 4 numerical "
      "failure; "
      "130, 143 stopped by Ctrl-C, SIGTERM.");
  return tenon::apps::RunMain(line, argc, argv, [&] { return tenon::apps::Tune(robot, evaluations); });
}
