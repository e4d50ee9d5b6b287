#pragma once

#include <tenon/apps/common/report_scenario.h>
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

/// Gains of an observer, given or designed; those that it has by default if there are none.
struct VariantScenario {
  std::string name;                              ///< of its directory, and in the report
  std::vector<double> gains_per_s;               ///< of the observer, from the innermost on
  std::optional<ButterworthDesign> butterworth;  ///< in place of gains: order and bandwidth

  static FieldList Fields() {
    return {Required("name", &VariantScenario::name),
            {"gains_per_s", &VariantScenario::gains_per_s},
            {"butterworth", &VariantScenario::butterworth}};
  }
  void Validate() const;  ///< throws ParameterError
  void Resolve();         ///< leaves gains alone
};

/// A run of tenon-observer-order, as its YAML file says it.
struct ObserverOrderScenario {
  std::string app;           ///< the app whose scenario this is
  std::string description;   ///< one line
  std::string case_name;     ///< the run's name
  YamlFile robot{"dogbot"};  ///< a shipped robot, a file, or one with what differs
  double duration_s = 1;     ///< simulated time
  std::uint64_t seed = 1;    ///< of all random streams
  JointPdScenario pd;        ///< by which it stands
  Eigen::Vector3d force_N = Eigen::Vector3d(20, 0, 10);  ///< on the front left foot, from `start_s` on
  double start_s = 0.2;                                  ///< of the force
  std::vector<VariantScenario> variants;                 ///< gains to compare
  double log_rate_hz = 1000;                             ///< of signals.csv
  ReportScenario report;                                 ///< what the report shows

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
            {"report", &ObserverOrderScenario::report}};
  }
  void Validate() const;  ///< throws ParameterError
};

}  // namespace tenon::apps
