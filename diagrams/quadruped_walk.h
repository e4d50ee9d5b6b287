#pragma once

#include <optional>

#include "tenon/controllers/legged_state_estimator.h"
#include "tenon/controllers/tracking_error.h"
#include "tenon/controllers/walk_schedule.h"
#include "tenon/diagrams/legged_locomotion.h"
#include "tenon/diagrams/quadruped_world.h"

namespace tenon {

struct QuadrupedWalkParams {
  QuadrupedWorldParams world;
  WalkScheduleParams walk;
  LeggedLocomotionParams locomotion;
  std::optional<LeggedStateEstimatorParams> estimator;  ///< without, the controller is told the true state
  QuadrupedDescription true_robot;  ///< without what disturbs it: errors are those of its CoM and feet
};

/// A quadruped that walks a commanded path on its terrain (Morlando 2023, section 2.5).
///
///     walk ──► locomotion ──► world ──┐
///                ▲                    │
///                └────────────────────┘ state, foot forces
///
/// or, with an estimator, by what its sensors tell:
///
///     walk ──► locomotion ──► world ──┐ foot forces
///                ▲  ▲     └─► estimator ◄── IMU, encoders
///                │  └── state ──┘     │
///                └────────────────────┘
class QuadrupedWalk final : public Subdiagram {
 public:
  explicit QuadrupedWalk(const QuadrupedWalkParams& params);

  WalkSchedule& walk;
  LeggedLocomotion& locomotion;
  QuadrupedWorld& world;
  LeggedStateEstimator* estimator = nullptr;  ///< if there is one
  TrackingError& errors;
};

}  // namespace tenon
