#pragma once

#include <tenon/controllers/legged/planning/periodic_pendulum.h>
#include <tenon/controllers/legged/planning/planar_spline.h>
#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/motion_signals.h>

#include <array>

namespace tenon {

/// How the optimisations of the CoM's spline went; zeros without any.
struct ComDiagnostics {
  long solves = 0;    ///< since the start of the run
  long failures = 0;  ///< of these found nothing, so that the old plan went on
  long failures_in_a_row = 0;
  int iterations = 0;                   ///< of the last
  QpStatus status = QpStatus::kSolved;  ///< of the last
  int constraint = -1;                  ///< that its status is about, see QpReport

  static FieldList Fields() {
    return {{"solves", &ComDiagnostics::solves},
            {"failures", &ComDiagnostics::failures},
            {"failures_in_a_row", &ComDiagnostics::failures_in_a_row},
            {"iterations", &ComDiagnostics::iterations},
            {"status", &ComDiagnostics::status},
            {"constraint", &ComDiagnostics::constraint}};
  }
};

/// A plan of the CoM's motion, made at one time and valid until the next.
struct ComPlan {
  int footsteps = -1;         ///< the schedule's count when it was made; none yet
  double start = 0;           ///< when it was made [s]
  PlanarPath path;            ///< then
  PeriodicPendulum pendulum;  ///< the CoM over ground, after blending,
  PlanarSpline spline;        ///< or, if it has segments, this, and beyond its end the path
  GroundPlane ground;         ///< below the robot
  double blend = 0;           ///< time until the old plan is forgotten [s]
  /// What is left of the old plan: (x, y, z, yaw, slope), coefficients of t^0 ... t^3.
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
