#pragma once

#include <tenon/controllers/guide_dog/admittance_filter.h>
#include <tenon/controllers/guide_dog/supervisor.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/plants/surroundings/leash.h>
#include <tenon/plants/surroundings/obstacle_detector.h>
#include <tenon/plants/surroundings/person.h>

namespace tenon {

struct GuideDogParams : QuadrupedWalkParams {
  SupervisorParams supervisor;
  AdmittanceFilterParams admittance;
  ObstacleDetectorParams obstacles;
  PersonParams person;
  LeashParams leash;
};

/// Returns the parameters of a guide dog with the walk of `walk` and the default person and leash. The person
/// stands still; set PersonParams::phases to move her.
GuideDogParams MakeGuideDog(const QuadrupedWalkParams& walk);

/// A walking quadruped that leads a person on a leash (Morlando 2023, section 2.5.4 and figure 2.29).
///
///     walk ──► supervisor ──► admittance ──► locomotion ──► world ──┐
///                ▲   ▲           ▲               ▲           ▲      │ state, sensors
///                │   └───────────┴─────────── observer ◄─────│──────┤
///            obstacles                         wrench        │      │
///                                                          leash ◄──┘
///                                                           ▲│
///                                                         person
///
/// The leash pulls at the trunk. The robot measures this force only by the observer's wrench: the whole-body
/// controller compensates the wrench, and the supervisor and the admittance filter change the command by it.
/// With an estimator, the schedule reaches it one tick late, because here the command depends on the state.
class GuideDog final : public QuadrupedWalk {
 public:
  explicit GuideDog(const GuideDogParams& params);

  Supervisor& supervisor;
  AdmittanceFilter& admittance;
  ObstacleDetector& obstacles;
  Person& person;
  Leash& leash;
};

}  // namespace tenon
