#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <tenon/apps/common/outputs.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>

namespace tenon::apps {

/// A run of tenon-guide-dog, as its YAML file says it.
struct GuideDogScenario {
  std::string app;
  std::string description;
  std::string case_name;
  std::string robot = "dogbot";      ///< a shipped robot or a YAML file
  std::optional<double> duration_s;  ///< without: one second longer than the walk
  std::uint64_t seed = 1;
  WalkScenario walk;  ///< of the robot if it were alone
  /// The tuning of the walking controller: a shipped one, a YAML file, or {file: standard, …} with what
  /// differs.
  YamlText profile{"standard"};
  ObserverKind observer = ObserverKind::kHybrid;
  SupervisorGains supervisor;
  AdmittanceGains admittance;
  PersonParams person;
  LeashParams leash;
  ObstacleDetectorParams surroundings;
  TerrainParams terrain;
  std::vector<ForceScenario> forces;
  std::vector<LeggedFault> faults;
  /// Drives, sensors and the link between: a shipped one, a YAML file, or {file: standard, …} with what
  /// differs.
  YamlText hardware{"ideal"};
  SensorScenario sensors;  ///< goes before what the hardware says
  FallScenario fall;
  bool limit_speed = false;  ///< the drives' torque falls with speed
  LeggedIntegratorScenario integrator;
  double log_rate_hz = 100;
  ReportScenario report;

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
            {"limit_speed", &S::limit_speed},
            {"integrator", &S::integrator},
            {"log_rate_hz", &S::log_rate_hz},
            {"report", &S::report}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// How long the run is [s].
double Duration(const GuideDogScenario& scenario);

/// What a scenario means in the diagram's terms. Throw ParameterError.
GuideDogParams MakeGuideDogParams(const GuideDogScenario& scenario);
SimulatorOptions MakeSimulatorOptions(const GuideDogScenario& scenario);

}  // namespace tenon::apps
