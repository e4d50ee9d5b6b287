#include <tenon/controllers/cdpr/cdpr_mpc.h>

#include <fmt/core.h>

#include <chrono>

namespace tenon {

std::pair<std::size_t, double> CdprPlan::Find(double time) const {
  std::size_t i = 0;
  while (i + 2 < nodes.size() && nodes[i + 1].time <= time) ++i;
  return {i, std::clamp((time - nodes[i].time) / (nodes[i + 1].time - nodes[i].time), 0.0, 1.0)};
}

void CdprPlan::Evaluate(double time, double estimated, const CentroidalState& x, CableVector* tension) const {
  const auto [i, a] = Find(time - start);
  const auto [j, b] = Find(estimated - start);
  const CentroidalState error = x - (1 - b) * nodes[j].x - b * nodes[j + 1].x;
  *tension = (1 - a) * nodes[i].u + a * nodes[i + 1].u;
  tension->noalias() += nodes[i].K * error;
}

void CdprMpc::CalcPlan(const double& time, const PlatformEstimate& estimate, const LoadEstimate& load,
                       const CableVector& broken, const FollowedPath& path, const CdprMpcCost& cost,
                       CdprPlan& warm_start, CdprMpcSolver& solver, CdprPlan* plan) const {
  if (broken.size() > 0) CheckNumCables(params.path->robot().num_cables(), broken.size(), "CdprMpc");
  const auto begin = std::chrono::steady_clock::now();
  const CentroidalState x = CentroidalStateOf(params.path->robot(), estimate.platform, load.payload);
  solver.Follow(path.path ? path.path : params.path);
  const SlqReport report = solver.Solve(time, x, load, broken, cost, warm_start);
  CdprMpcDiagnostics& diagnostics = warm_start.diagnostics;
  ++diagnostics.solves;
  if (report.ok()) {
    diagnostics.fallbacks_in_a_row = 0;
    diagnostics.cost = report.cost;
  } else {
    ++diagnostics.fallbacks;
    ++diagnostics.fallbacks_in_a_row;
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  *plan = warm_start;
  plan->diagnostics.solve_time =
      elapsed.count();  // not in warm_start: states must not depend on the wall clock
}

void CdprMpc::CalcCommand(const double& time, const PlatformEstimate& estimate, const CdprPlan& plan,
                          const CableVector& broken, const FollowedPath& path, CdprReference& reference,
                          CableVector* command) const {
  const CdprDescription& robot = params.path->robot();
  plan.Evaluate(time, estimate.time, CentroidalStateOf(robot, estimate.platform, plan.payload), command);
  (path.path ? *path.path : *params.path).At(time + robot.winch.time_constant, &reference);
  *command -= robot.winch.reel_damping * reference.length_rate;
  *command += robot.winch.time_constant * plan.reference_rate;
  robot.LimitTension(command);
  for (Eigen::Index i = 0; i < broken.size(); ++i)
    if (broken[i] != 0) (*command)[i] = 0;
}

Verdict CdprMpc::CheckFallbacks(const CdprPlan& plan, int max_fallbacks_in_a_row) const {
  const CdprMpcDiagnostics& diagnostics = plan.diagnostics;
  if (diagnostics.fallbacks_in_a_row <= max_fallbacks_in_a_row) return {};
  return fmt::format("{} solves of the MPC in a row failed ({} of {} solves in all)",
                     diagnostics.fallbacks_in_a_row, diagnostics.fallbacks, diagnostics.solves);
}

Verdict CdprMpc::CheckStatics(const CdprPlan& plan, const CableVector& broken) const {
  const double unheld = static_cast<double>(plan.unheld_in_a_row) * params.rate.period();
  if (plan.shift.held || unheld < params.unheld_time) return {};
  std::string which;
  for (Eigen::Index i = 0; i < broken.size(); ++i)
    if (broken[i] != 0) which += (which.empty() ? "" : ", ") + std::to_string(i);
  return fmt::format("without cable {} the others cannot hold the platform at its reference", which);
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::CdprPlan);
TENON_DEFINE_SIGNAL(tenon::CdprMpcDiagnostics);
