#pragma once

#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>

namespace tenon::apps {

/// The task of a case, see GuideDogFigures.
struct GuideDogTask : Task {
  double crossing = 5;  ///< time after the person stopped until the leash stops the robot [s]
  double stop = 1;      ///< time from the cause of the first stop until the robot stands [s]
  double restart = 15;  ///< time after the last pull until the robot walks along it for 1 s [s]
  double heading = 5;   ///< deviation of its heading from the pull, then and at the end [deg]

  static FieldList Fields() {
    using T = GuideDogTask;
    return Task::Fields() + FieldList{Field("crossing_s", &T::crossing).Positive(),
                                      Field("stop_s", &T::stop).Positive(),
                                      Field("restart_s", &T::restart).Positive(),
                                      Field("heading_deg", &T::heading).Positive()};
  }
};

/// Scenario of tenon-guide-dog, read from a YAML file. With `scale_forces`, the forces and stiffnesses of the
/// person and the leash are scaled to the robot's weight, too.
struct GuideDogScenario : LeggedScenario {
  WalkScenario walk;                     ///< walk that the robot would make without a person
  std::optional<ObserverKind> observer;  ///< overrides the observer of the profile
  SupervisorGains supervisor;
  AdmittanceGains admittance;
  PersonParams person;
  LeashParams leash;
  ObstacleDetectorParams surroundings;  ///< obstacles and the range of the robot's obstacle detector
  GuideDogTask task;                    ///< task, without which the case is not finished
  double log_rate_hz = 100;             ///< sample rate of signals.csv

  static FieldList Fields() {
    using S = GuideDogScenario;
    return LeggedScenario::Fields() + FieldList{Required("walk", &S::walk),
                                                {"observer", &S::observer},
                                                {"supervisor", &S::supervisor},
                                                {"admittance", &S::admittance},
                                                Required("person", &S::person),
                                                {"leash", &S::leash},
                                                {"surroundings", &S::surroundings},
                                                {"task", &S::task},
                                                Field("log_rate_hz", &S::log_rate_hz).In(Rates())};
  }
};

/// Simulated time [s].
double Duration(const GuideDogScenario& scenario);

/// Reads the files that a scenario names and translates it into parameters of a diagram. Throws KeyError.
GuideDogParams MakeGuideDogParams(const GuideDogScenario& scenario);

}  // namespace tenon::apps
