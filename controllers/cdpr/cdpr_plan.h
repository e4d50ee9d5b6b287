#pragma once

#include <tenon/controllers/cdpr/balanced_reference.h>
#include <tenon/controllers/cdpr/kino_centroidal_model.h>

namespace tenon {

/// Statistics of the solves of the cable robot's MPC.
struct CdprMpcDiagnostics {
  long solves = 0;     ///< since the start of the run
  long fallbacks = 0;  ///< solves that failed, after which the last policy stayed in use
  long fallbacks_in_a_row = 0;
  double cost = 0;        ///< cost of the nominal trajectory
  double solve_time = 0;  ///< wall-clock time of the last solve [s]; does not affect the run

  static FieldList Fields() {
    return {{"solves", &CdprMpcDiagnostics::solves},
            {"fallbacks", &CdprMpcDiagnostics::fallbacks},
            {"fallbacks_in_a_row", &CdprMpcDiagnostics::fallbacks_in_a_row},
            {"cost", &CdprMpcDiagnostics::cost},
            {"solve_time", &CdprMpcDiagnostics::solve_time, "s"}};
  }
};

/// The policy of the cable robot's MPC: u(t, x) = u_bar(t) + K(t) (x - x_bar(t)), eq. (3.18).
struct CdprPlan {
  struct Node {
    double time = 0;              ///< time from `start` [s]
    Vec<12> x = Vec<12>::Zero();  ///< nominal state, see CentroidalState
    CableVector u;                ///< nominal tensions [N]
    Eigen::Matrix<double, Eigen::Dynamic, 12, Eigen::DontAlign> K;
    CableVector multipliers;  ///< of the distances that are kept, see CdprClearance

    static FieldList Fields() {
      return {{"time", &Node::time, "s"},
              {"x", &Node::x},
              {"u", &Node::u, "N"},
              {"K", &Node::K},
              {"multipliers", &Node::multipliers}};
    }
  };

  double start = 0;  ///< time of the first node [s]
  std::vector<Node> nodes;
  Payload payload;             ///< in the model of the policy; states are about the common CoM
  ReferenceShift shift;        ///< shift of the reference by the load, at the start
  long unheld_in_a_row = 0;    ///< solves at which the intact cables could not hold the platform
  CableVector reference_rate;  ///< rate of the equilibrium's tensions at the start [N/s]
  CdprMpcDiagnostics diagnostics;

  static FieldList Fields() {
    return {{"start", &CdprPlan::start, "s"},
            {"nodes", &CdprPlan::nodes},
            {"payload", &CdprPlan::payload},
            {"shift", &CdprPlan::shift},
            {"unheld_in_a_row", &CdprPlan::unheld_in_a_row},
            {"reference_rate", &CdprPlan::reference_rate, "N/s"},
            {"diagnostics", &CdprPlan::diagnostics}};
  }

  /// The last node that is not after `time` [s], counted from `start`, and the fraction of its step that has
  /// passed.
  std::pair<std::size_t, double> Find(double time) const;
  /// Tensions of the policy at `time` for a state x estimated at the time `estimated` <= `time` [s], without
  /// clamping. Does not allocate if `tension` has the plan's size.
  void Evaluate(double time, double estimated, const CentroidalState& x, CableVector* tension) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::CdprPlan);
TENON_DECLARE_SIGNAL(tenon::CdprMpcDiagnostics);
