#pragma once

#include <memory>

#include <tenon/controllers/cdpr/cdpr_estimator.h>
#include <tenon/controllers/cdpr/cdpr_mpc_solver.h>
#include <tenon/controllers/cdpr/cdpr_plan.h>

namespace tenon {

/// The model predictive controller of the cable robot (Morlando 2023, section 3.4): SLQ on the
/// kino-centroidal model, one call per period, warm-started with its last policy.
///
/// What goes to the winches is the policy with its feedback, at the winches' rate:
///
///     command = clamp(u_bar(t) + K (x_hat - x_bar) - b dl_ref/dt)
///
/// The last term is the tension that the reel damping b of the winches adds when the cables run as the
/// reference says; the bounds hold for the command.
///
/// If a solve fails (no descent, or not finite) the last policy goes on and is counted; after
/// `max_fallbacks_in_a_row` the run ends.
///
///     port in   estimate  the platform's state
///     ports out plan      the policy, sampled
///               command   [N], one per cable, sampled
///               diagnostics
class CdprMpc final : public LeafSystem<CdprMpcParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<PlatformEstimate> estimate{this, {"estimate"}};
  Scratch<CdprPlan> warm_start{this, "warm_start", CdprMpcSolver::FirstPlan(params)};
  Workspace<CdprMpcSolver> solver{this, "solver", CdprMpcSolver(params)};
  OutputPort<CdprPlan> plan{this,
                            {"plan"},
                            CdprMpcSolver::FirstPlan(params),
                            Sampled{params.rate},
                            Uses(time, estimate, warm_start, solver),
                            &CdprMpc::CalcPlan};
  OutputPort<CableVector> command{this,
                                  {"command", "N"},
                                  CableVector::Zero(params.path->robot().num_cables()),
                                  Sampled{params.command_rate},
                                  Uses(time, estimate, plan),
                                  &CdprMpc::CalcCommand};
  OutputPort<CdprMpcDiagnostics> diagnostics{this, {"diagnostics"}, Uses(plan), &CdprMpc::CalcDiagnostics};
  Monitor fallbacks{this, "fallbacks", Sampled{params.rate}, Uses(plan), &CdprMpc::CheckFallbacks};

 private:
  void CalcPlan(const double& time, const PlatformEstimate& estimate, CdprPlan& warm_start,
                CdprMpcSolver& solver, CdprPlan* plan) const;
  CableVector CalcCommand(const double& time, const PlatformEstimate& estimate, const CdprPlan& plan) const;
  CdprMpcDiagnostics CalcDiagnostics(const CdprPlan& plan) const { return plan.diagnostics; }
  Verdict CheckFallbacks(const CdprPlan& plan) const;
};

}  // namespace tenon
