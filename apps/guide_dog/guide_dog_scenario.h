#pragma once

#include <tenon/apps/common/report_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

/// A run of tenon-guide-dog, as its YAML file says it.
struct GuideDogScenario {
  std::string app;                        ///< the app whose scenario this is
  std::string description;                ///< one line
  std::string case_name;                  ///< the run's name
  YamlFile robot{"dogbot"};               ///< a shipped robot, a file, or one with what differs
  std::optional<double> duration_s;       ///< without: one second longer than the walk
  std::uint64_t seed = kRecommendedSeed;  ///< of all random streams
  WalkScenario walk;                      ///< of the robot if it were alone
  /// The tuning of the walking controller: a shipped one, a YAML file, or {file: standard, …} with what
  /// differs.
  YamlFile profile{"standard"};
  ObserverKind observer = DisturbanceObserverParams().kind;  ///< of the forces of others
  SupervisorGains supervisor;
  AdmittanceGains admittance;
  PersonParams person;
  LeashParams leash;
  ObstacleDetectorParams surroundings;  ///< what stands in the way, and how far the robot sees it
  TerrainParams terrain;                ///< the ground
  std::vector<ForceScenario> forces;    ///< on trunk and legs
  std::vector<LeggedFault> faults;      ///< what breaks, and when
  /// Drives, sensors and the link between: a shipped one, a YAML file, or {file: standard, …} with what
  /// differs.
  YamlFile hardware{"ideal"};
  SensorScenario sensors;  ///< goes before what the hardware says
  FallScenario fall;
  LiveScenario live;
  bool limit_speed =
      QuadrupedPlantParams()
          .limit_speed;  ///< the drives' torque falls with speed; without, no verdict is good that needs more
  LeggedIntegration integrator;
  /// Forces, person, leash and blocks are DogBot's: times the robot's weight over DogBot's, see
  /// ScaledToRobot.
  bool scale_forces = false;
  double log_rate_hz = 100;                               ///< of signals.csv
  ReportScenario report;                                  ///< what the report shows
  std::map<std::string, std::vector<double>> parameters;  ///< of the diagram, by path: set at the start

  static FieldList Fields() {
    using S = GuideDogScenario;
    return {Required("app", &S::app),
            {"description", &S::description},
            Required("case", &S::case_name),
            {"robot", &S::robot},
            {"duration_s", &S::duration_s},
            {"seed", &S::seed},
            Required("walk", &S::walk),
            {"profile", &S::profile},
            {"observer", &S::observer},
            {"supervisor", &S::supervisor},
            {"admittance", &S::admittance},
            Required("person", &S::person),
            {"leash", &S::leash},
            {"surroundings", &S::surroundings},
            {"terrain", &S::terrain},
            {"forces", &S::forces},
            {"faults", &S::faults},
            {"hardware", &S::hardware},
            {"sensors", &S::sensors},
            {"fall", &S::fall},
            {"live", &S::live},
            {"limit_speed", &S::limit_speed},
            {"integrator", &S::integrator},
            {"scale_forces", &S::scale_forces},
            {"log_rate_hz", &S::log_rate_hz},
            {"report", &S::report},
            {"parameters", &S::parameters}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// How long the run is [s].
double Duration(const GuideDogScenario& scenario);

/// The keys of a scenario that do nothing in a run of `duration` [s], each with the reason.
std::vector<std::string> Notes(const GuideDogScenario& scenario, double duration);

/// What a scenario means in the diagram's terms. Throw ParameterError.
GuideDogParams MakeGuideDogParams(const GuideDogScenario& scenario);
SimulatorOptions MakeSimulatorOptions(const GuideDogScenario& scenario);

}  // namespace tenon::apps
