#pragma once

#include "tenon/controllers/tracking_error.h"
#include "tenon/controllers/walk_schedule.h"
#include "tenon/diagrams/legged_locomotion.h"
#include "tenon/diagrams/quadruped_world.h"

namespace tenon {

struct QuadrupedWalkParams {
  QuadrupedWorldParams world;
  WalkScheduleParams walk;
  LeggedLocomotionParams locomotion;
  QuadrupedDescription true_robot;  ///< without what disturbs it: errors are those of its CoM and feet
};

/// A quadruped that walks a commanded path on its terrain (Morlando 2023, section 2.5).
///
///     walk ──► locomotion ──► world ──┐
///                ▲                    │
///                └────────────────────┘ state, foot forces
class QuadrupedWalk final : public Subdiagram {
 public:
  explicit QuadrupedWalk(const QuadrupedWalkParams& params);

  WalkSchedule& walk;
  LeggedLocomotion& locomotion;
  QuadrupedWorld& world;
  TrackingError& errors;
};

}  // namespace tenon
