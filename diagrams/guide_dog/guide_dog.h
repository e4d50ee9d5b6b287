#pragma once

#include <tenon/controllers/guide_dog/admittance_filter.h>
#include <tenon/controllers/guide_dog/supervisor.h>
#include <tenon/controllers/legged/observers/foot_force_estimate.h>
#include <tenon/controllers/legged/observers/legged_state_estimator.h>
#include <tenon/controllers/legged/planning/walk_schedule.h>
#include <tenon/diagrams/legged/disturbance_observer.h>
#include <tenon/diagrams/legged/legged_locomotion.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/plants/surroundings/leash.h>
#include <tenon/plants/surroundings/obstacle_detector.h>
#include <tenon/plants/surroundings/person.h>

#include <optional>

namespace tenon {

class FootForcesOfLegs;
class TrackingError;
class WalkView;

struct GuideDogParams {
  QuadrupedWorldParams world;
  WalkScheduleParams walk;
  LeggedLocomotionParams locomotion;
  DisturbanceObserverParams observer;
  std::optional<LeggedStateEstimatorParams> estimator;  ///< without, the robot is told its true state
  SupervisorParams supervisor;
  AdmittanceFilterParams admittance;
  ObstacleDetectorParams obstacles;
  PersonParams person;
  LeashParams leash;
};

/// The robot of this walk, the person and the leash; left to give is what the person does.
GuideDogParams MakeGuideDog(const QuadrupedWalkParams& walk);

/// A quadruped that leads a person on a leash (Morlando 2023, section 2.5.4 and figure 2.29).
///
///     walk ──► supervisor ──► admittance ──► locomotion ──► world ──┐
///                ▲   ▲           ▲               ▲           ▲      │ state, sensors
///                │   └───────────┴─────────── observer ◄─────│──────┤
///            obstacles                         wrench        │      │
///                                                          leash ◄──┘
///                                                           ▲│
///                                                         person
///
/// The leash pulls at the trunk; the robot knows of it by the observer's wrench alone, which the whole-body
/// controller compensates and supervisor and admittance filter answer to. With an estimator all blocks of the
/// robot go by its state; then the schedule reaches it a tick late, for the command depends on the state.
class GuideDog final : public Subdiagram {
 public:
  explicit GuideDog(const GuideDogParams& params);

  WalkSchedule& walk;
  Supervisor& supervisor;
  AdmittanceFilter& admittance;
  LeggedLocomotion& locomotion;
  QuadrupedWorld& world;
  DisturbanceObserver& observer;
  ObstacleDetector& obstacles;
  Person& person;
  Leash& leash;
  LeggedStateEstimator* estimator = nullptr;         ///< if there is one
  FootForceEstimate* foot_force_estimate = nullptr;  ///< if the sensors of the feet are in the shanks
  FootForcesOfLegs* foot_forces_of_legs = nullptr;   ///< if the feet have none
  TrackingError& errors;
  WalkView& view;
};

}  // namespace tenon
