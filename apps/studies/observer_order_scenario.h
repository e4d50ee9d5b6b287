#pragma once

#include <tenon/apps/common/log_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/yaml/yaml.h>

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

/// Gains of a leg observer, given or designed. The default gains if neither is given.
struct VariantScenario {
  std::string name;                              ///< name in the report, and of the output directory
  std::vector<double> gains_per_s;               ///< gains of the observer, the innermost first
  std::optional<ButterworthDesign> butterworth;  ///< design of the gains by order and bandwidth

  static FieldList Fields() {
    return {Required("name", &VariantScenario::name),
            {"gains_per_s", &VariantScenario::gains_per_s},
            {"butterworth", &VariantScenario::butterworth}};
  }
  void Validate() const;  ///< throws ParameterError
  void Resolve();         ///< replaces `butterworth` by its gains
};

/// Scenario of tenon-observer-order, read from a YAML file.
struct ObserverOrderScenario {
  std::string app;           ///< name of the app that runs the scenario
  std::string description;   ///< description of the scenario in one line
  std::string case_name;     ///< name of the run
  YamlFile robot{"dogbot"};  ///< a shipped robot, a YAML file, or one of these with changes
  double duration_s = 1;     ///< simulated time
  std::uint64_t seed = 1;    ///< seed of all random streams
  JointPdScenario pd;        ///< joint PD controller that holds the stance
  Eigen::Vector3d force_N = Eigen::Vector3d(20, 0, 10);  ///< force on the front left foot, from `start_s` on
  double start_s = 0.2;                                  ///< time at which the force sets in
  std::vector<VariantScenario> variants;                 ///< variants of the observer to compare
  double log_rate_hz = 1000;                             ///< sample rate of signals.csv
  ReportScenario report;                                 ///< contents of the report
  LogScenario log;                                       ///< signals to log in addition to those of the app

  static FieldList Fields() {
    return {Required("app", &ObserverOrderScenario::app),
            {"description", &ObserverOrderScenario::description},
            Required("case", &ObserverOrderScenario::case_name),
            {"robot", &ObserverOrderScenario::robot},
            {"duration_s", &ObserverOrderScenario::duration_s},
            {"seed", &ObserverOrderScenario::seed},
            Required("pd", &ObserverOrderScenario::pd),
            {"force_N", &ObserverOrderScenario::force_N},
            {"start_s", &ObserverOrderScenario::start_s},
            Required("variants", &ObserverOrderScenario::variants),
            {"log_rate_hz", &ObserverOrderScenario::log_rate_hz},
            {"report", &ObserverOrderScenario::report},
            {"log", &ObserverOrderScenario::log}};
  }
  void Validate() const;  ///< throws ParameterError
};

}  // namespace tenon::apps
