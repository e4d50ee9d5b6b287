#pragma once

#include <tenon/controllers/cdpr/cdpr_estimator.h>
#include <tenon/controllers/cdpr/cdpr_mpc_solver.h>

namespace tenon {

/// The model predictive controller of the cable robot (Morlando 2023, section 3.4): SLQ on the
/// kino-centroidal model, one solve per period, warm-started with the last policy.
///
/// Between solves the command follows the policy with its feedback, at the rate of the winches:
///
///     command = clamp(u_bar(t) + K (x_hat - x_bar) - b dl_ref/dt (t + T) + T du_ref/dt)
///
/// The last two terms compensate the tension that the reel damping b of the winches adds at the reference's
/// cable speeds, and the lag T of their motors. The bounds hold for the command.
///
/// If a solve fails (no descent, or not finite) the last policy stays in use. After more than
/// `max_fallbacks_in_a_row` failures the run ends.
///
/// The model and the reference include the load of LoadEstimator, so that a constant load leaves no error.
/// Cables that BrokenCableDetector reports as broken have the command 0 and the others replace them. If these
/// cannot hold the platform for `unheld_time`, the run ends. A connected `path` replaces the parameter, see
/// GoalPath.
class CdprMpc : public LeafSystem<CdprMpcParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<PlatformEstimate> estimate{this, {"estimate"}};
  InputPort<LoadEstimate> load{this, {"load"}, LoadEstimate{}};
  InputPort<CableVector> broken{this, {"broken"}, CableVector{}};
  InputPort<FollowedPath> path{this, {"path"}, FollowedPath{}};
  Parameter<CdprMpcWeights> weights{
      this, {"weights"}, params.weights, "weights of the squared errors, per second"};
  Parameter<CdprMpcWeights> terminal_weights{this,
                                             {"terminal_weights"},
                                             params.terminal_weights,
                                             "weights of the final errors for a diagonal terminal cost"};
  Parameter<int> max_fallbacks_in_a_row{this,
                                        {"max_fallbacks_in_a_row"},
                                        params.max_fallbacks_in_a_row,
                                        "consecutive failed solves above which the run ends",
                                        Range().AtLeast(0).Because("below 0 every solve ends the run")};
  Shared<CdprMpcCost> cost{this, "cost", Uses(weights, terminal_weights), &CdprMpc::CalcCost};
  Scratch<CdprPlan> warm_start{this, "warm_start", CdprMpcSolver::FirstPlan(params)};
  Workspace<CdprMpcSolver> solver{this, "solver", CdprMpcSolver(params)};
  OutputPort<CdprPlan> plan{this,
                            {"plan"},
                            CdprMpcSolver::FirstPlan(params),
                            Sampled{params.rate},
                            Uses(time, estimate, load, broken, path, cost, warm_start, solver),
                            &CdprMpc::CalcPlan};
  Workspace<CdprReference> reference{this, "reference", params.path->At(0)};
  OutputPort<CableVector> command{this,
                                  {"command", "N"},
                                  CableVector::Zero(params.path->robot().num_cables()),
                                  Sampled{params.command_rate},
                                  Uses(time, estimate, plan, broken, path, reference),
                                  &CdprMpc::CalcCommand};
  OutputPort<CdprMpcDiagnostics> diagnostics{this, {"diagnostics"}, Uses(plan), &CdprMpc::CalcDiagnostics};
  Monitor fallbacks{this, "fallbacks", Sampled{params.rate}, Uses(plan, max_fallbacks_in_a_row),
                    &CdprMpc::CheckFallbacks};
  Monitor statics{this, "statics", Sampled{params.rate}, Uses(plan, broken), &CdprMpc::CheckStatics};

 private:
  CdprMpcCost CalcCost(const CdprMpcWeights& weights_now, const CdprMpcWeights& terminal_weights_now) const {
    return CdprMpcSolver::Cost(params, weights_now, terminal_weights_now);
  }
  void CalcPlan(const double& time, const PlatformEstimate& estimate, const LoadEstimate& load,
                const CableVector& broken, const FollowedPath& path, const CdprMpcCost& cost,
                CdprPlan& warm_start, CdprMpcSolver& solver, CdprPlan* plan) const;
  void CalcCommand(const double& time, const PlatformEstimate& estimate, const CdprPlan& plan,
                   const CableVector& broken, const FollowedPath& path, CdprReference& reference,
                   CableVector* command) const;
  CdprMpcDiagnostics CalcDiagnostics(const CdprPlan& plan_now) const { return plan_now.diagnostics; }
  Verdict CheckFallbacks(const CdprPlan& plan, int max_fallbacks_in_a_row) const;
  Verdict CheckStatics(const CdprPlan& plan, const CableVector& broken) const;
};

}  // namespace tenon
