#pragma once

#include <tenon/controllers/legged/planning/periodic_pendulum.h>
#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/plants/signals/ground_plane.h>

namespace tenon {

/// Statistics of the optimisations of the CoM spline; zeros without a spline.
struct ComDiagnostics {
  long solves = 0;                      ///< since the start of the run
  long failures = 0;                    ///< failed solves, after which the previous plan stays
  long failures_in_a_row = 0;           ///< failed solves since the last success
  int iterations = 0;                   ///< iterations of the last solve
  QpStatus status = QpStatus::kSolved;  ///< status of the last solve
  int constraint = -1;                  ///< constraint that the status refers to, see QpReport

  /// Counts a solve.
  void Count(const QpReport& report) {
    ++solves;
    failures += !report.ok();
    failures_in_a_row = report.ok() ? 0 : failures_in_a_row + 1;
    iterations = report.iterations;
    status = report.status;
    constraint = report.constraint;
  }
  static FieldList Fields() {
    return {{"solves", &ComDiagnostics::solves},
            {"failures", &ComDiagnostics::failures},
            {"failures_in_a_row", &ComDiagnostics::failures_in_a_row},
            {"iterations", &ComDiagnostics::iterations},
            {"status", &ComDiagnostics::status},
            {"constraint", &ComDiagnostics::constraint}};
  }
};

/// Plan of the CoM's motion, valid until the next plan.
struct ComPlan {
  int footsteps = -1;         ///< the schedule's count of footsteps when it was made; -1: no plan yet
  double start = 0;           ///< time when it was made [s]
  PlanarPath path;            ///< commanded path at `start`
  PeriodicPendulum pendulum;  ///< horizontal motion of the CoM after blending, if `spline` is empty
  PlanarSpline spline;        ///< horizontal motion of the CoM; continues as `path` beyond its end
  GroundPlane ground;         ///< below the robot
  double blend = 0;           ///< duration of the transition from the previous plan [s]
  /// Difference to the previous plan, in (x, y, z, yaw, slope), as coefficients of t^0 ... t^3.
  std::array<Vec<6>, 4> remainder{Vec<6>::Zero(), Vec<6>::Zero(), Vec<6>::Zero(), Vec<6>::Zero()};
  ComDiagnostics diagnostics;

  static FieldList Fields() {
    return {{"footsteps", &ComPlan::footsteps},
            {"start", &ComPlan::start, "s"},
            {"path", &ComPlan::path},
            {"pendulum", &ComPlan::pendulum},
            {"spline", &ComPlan::spline},
            {"ground", &ComPlan::ground},
            {"blend", &ComPlan::blend, "s"},
            {"remainder", &ComPlan::remainder},
            {"diagnostics", &ComPlan::diagnostics}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::ComPlan);
TENON_DECLARE_SIGNAL(tenon::ComDiagnostics);
