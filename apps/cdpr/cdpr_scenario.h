#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <tenon/apps/cdpr/cdpr_faults.h>
#include <tenon/apps/cdpr/cdpr_hardware.h>
#include <tenon/apps/common/outputs.h>
#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/systems/framework/fields.h>
#include <tenon/systems/simulation/simulator_options.h>

namespace tenon::apps {

enum class PathKind { kHold, kLine, kCircle, kSpline };
constexpr auto EnumNames(PathKind) {
  return std::array{Named{PathKind::kHold, "hold"}, Named{PathKind::kLine, "line"},
                    Named{PathKind::kCircle, "circle"}, Named{PathKind::kSpline, "spline"}};
}

/// The path of the platform's CoM, in the world.
struct PathScenario {
  PathKind kind = PathKind::kCircle;
  Eigen::Vector3d center_m{0, 0, 2};  ///< of the circle
  double radius_m = 0.5;
  double period_s = 10;
  double ramp_s = 5;                      ///< time in which the circle's speed is reached
  std::vector<Eigen::Vector3d> points_m;  ///< of hold (1), line (2) and spline
  std::vector<double> times_s;            ///< of the points; a line and a spline need them
  /// Roll, pitch, yaw all along the path, for robots of six cables or more; else the equilibrium's.
  std::optional<Eigen::Vector3d> attitude_rad;
  double tension_aim_N = 0;  ///< with an attitude: of the tensions that hold it, those nearest to this

  static FieldList Fields() {
    return {Required("kind", &PathScenario::kind),
            {"center_m", &PathScenario::center_m},
            {"radius_m", &PathScenario::radius_m},
            {"period_s", &PathScenario::period_s},
            {"ramp_s", &PathScenario::ramp_s},
            {"points_m", &PathScenario::points_m},
            {"times_s", &PathScenario::times_s},
            {"attitude_rad", &PathScenario::attitude_rad},
            {"tension_aim_N", &PathScenario::tension_aim_N}};
  }
  void Validate() const;  ///< throws ParameterError
  Path Make() const;
};

struct PdScenario {
  double stiffness_N_per_m = 0;
  double damping_N_s_per_m = 0;
  double rate_hz = 1000;

  static FieldList Fields() {
    return {Required("stiffness_N_per_m", &PdScenario::stiffness_N_per_m),
            Required("damping_N_s_per_m", &PdScenario::damping_N_s_per_m),
            {"rate_hz", &PdScenario::rate_hz}};
  }
  void Validate() const;  ///< throws ParameterError
};

struct MpcScenario {
  double horizon_s = 1;
  int num_steps = 25;
  double rate_hz = 100;
  double command_rate_hz = 1000;
  CdprMpcWeights weights;
  StepMethod method = StepMethod::kRungeKutta4;
  double mass_error = 0;  ///< of the controller's model: 0.3 is 30 % too heavy
  int max_fallbacks_in_a_row = 50;
  bool offset_free = true;  ///< of mpc_equilibrium: the load is estimated, and in model and reference

  static FieldList Fields() {
    return {{"horizon_s", &MpcScenario::horizon_s},
            {"num_steps", &MpcScenario::num_steps},
            {"rate_hz", &MpcScenario::rate_hz},
            {"command_rate_hz", &MpcScenario::command_rate_hz},
            Required("weights", &MpcScenario::weights),
            {"method", &MpcScenario::method},
            {"mass_error", &MpcScenario::mass_error},
            {"max_fallbacks_in_a_row", &MpcScenario::max_fallbacks_in_a_row},
            {"offset_free", &MpcScenario::offset_free}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A mass hung at the platform for part of the run; the controller does not know of it.
struct PayloadScenario {
  double mass_kg = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< in the platform's frame, from its CoM
  double attach_s = 0;
  double release_s = 0;

  static FieldList Fields() {
    return {{"mass_kg", &PayloadScenario::mass_kg},
            {"position_m", &PayloadScenario::position_m},
            {"attach_s", &PayloadScenario::attach_s},
            {"release_s", &PayloadScenario::release_s}};
  }
  void Validate() const;  ///< throws ParameterError
};

struct NoiseScenario {
  double position_m = 0.005;
  double attitude_rad = 0.01;
  double angular_velocity_rad_per_s = 0.005;
  double acceleration_m_per_s2 = 0.05;
  double pose_rate_hz = 200;
  double imu_rate_hz = 200;

  static FieldList Fields() {
    return {{"position_m", &NoiseScenario::position_m},
            {"attitude_rad", &NoiseScenario::attitude_rad},
            {"angular_velocity_rad_per_s", &NoiseScenario::angular_velocity_rad_per_s},
            {"acceleration_m_per_s2", &NoiseScenario::acceleration_m_per_s2},
            {"pose_rate_hz", &NoiseScenario::pose_rate_hz},
            {"imu_rate_hz", &NoiseScenario::imu_rate_hz}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// The defaults take one step per millisecond on D1; the platform is then 3 micrometres off a run with order
/// 5 and rtol 1e-9 after 20 s.
struct IntegratorScenario {
  int order = 2;
  double rtol = 1e-3;
  double atol = 1e-5;

  static FieldList Fields() {
    return {{"order", &IntegratorScenario::order},
            {"rtol", &IntegratorScenario::rtol},
            {"atol", &IntegratorScenario::atol}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// How the load on the platform is estimated, for controllers that are offset-free; see LoadEstimator.
/// Without values the MPC has 20 and 100 rad/s, the PD 3 and 3: what it is told sooner slackens cables when
/// D2's load is released, from 5 rad/s on.
struct LoadEstimateScenario {
  std::optional<double> bandwidth_rad_per_s;
  std::optional<double> mass_bandwidth_rad_per_s;

  static FieldList Fields() {
    return {{"bandwidth_rad_per_s", &LoadEstimateScenario::bandwidth_rad_per_s},
            {"mass_bandwidth_rad_per_s", &LoadEstimateScenario::mass_bandwidth_rad_per_s}};
  }
};

enum class CdprController {
  kMpcEquilibrium,  ///< offset-free, unless mpc.offset_free says no
  kMpcZero,         ///< Morlando 2023: tensions as small as may be; knows of no load
  kPd,              ///< of the cables' lengths, to those of the static equilibrium
  kPdFeedforward,   ///< and of what accelerates the platform
  kPdOffsetFree,    ///< and of the load that is estimated
};
constexpr auto EnumNames(CdprController) {
  return std::array{Named{CdprController::kMpcEquilibrium, "mpc_equilibrium"},
                    Named{CdprController::kMpcZero, "mpc_zero"}, Named{CdprController::kPd, "pd"},
                    Named{CdprController::kPdFeedforward, "pd_feedforward"},
                    Named{CdprController::kPdOffsetFree, "pd_offset_free"}};
}
constexpr bool IsMpc(CdprController controller) {
  return controller == CdprController::kMpcEquilibrium || controller == CdprController::kMpcZero;
}

/// A run of tenon-cdpr, as its YAML file says it.
struct CdprScenario {
  std::string app;
  std::string description;
  std::string case_name;
  std::string robot = "cdpr_4";  ///< a shipped robot or a YAML file
  double duration_s = 60;
  std::uint64_t seed = 1;
  CdprController controller = CdprController::kPd;
  PathScenario path;
  PdScenario pd;
  std::optional<MpcScenario> mpc;  ///< needed for the controllers mpc_...
  LoadEstimateScenario load;
  Eigen::Vector3d start_offset_m{0, 0, 0};  ///< of the platform from the start of the path
  Eigen::Vector3d start_turn_rad{0, 0, 0};  ///< added to roll, pitch, yaw there
  PayloadScenario payload;
  NoiseScenario noise;
  /// Winches, sensors and the link between: a shipped one, a YAML file, or {file: standard, …} with what
  /// differs.
  YamlText hardware{"ideal"};
  std::vector<CdprFault> faults;
  IntegratorScenario integrator;
  double log_rate_hz = 200;
  bool forbid_slack = true;        ///< a slack cable ends the run, exit code 3
  double max_tension_ratio = 1.1;  ///< so does one pulled harder than this times the winches' maximum
  ReportScenario report;

  static FieldList Fields() {
    return {Required("app", &CdprScenario::app),
            {"description", &CdprScenario::description},
            Required("case", &CdprScenario::case_name),
            {"robot", &CdprScenario::robot},
            {"duration_s", &CdprScenario::duration_s},
            {"seed", &CdprScenario::seed},
            {"controller", &CdprScenario::controller},
            Required("path", &CdprScenario::path),
            Required("pd", &CdprScenario::pd),
            {"mpc", &CdprScenario::mpc},
            {"load", &CdprScenario::load},
            {"start_offset_m", &CdprScenario::start_offset_m},
            {"start_turn_rad", &CdprScenario::start_turn_rad},
            {"payload", &CdprScenario::payload},
            {"noise", &CdprScenario::noise},
            {"hardware", &CdprScenario::hardware},
            {"faults", &CdprScenario::faults},
            {"integrator", &CdprScenario::integrator},
            {"log_rate_hz", &CdprScenario::log_rate_hz},
            {"forbid_slack", &CdprScenario::forbid_slack},
            {"max_tension_ratio", &CdprScenario::max_tension_ratio},
            {"report", &CdprScenario::report}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// What the diagram needs to know of a scenario. Reads the robot, and finds the equilibria along the path, so
/// that a path outside the workspace is refused here, before any run.
CdprLoopParams MakeLoopParams(const CdprScenario& scenario);
SimulatorOptions MakeSimulatorOptions(const CdprScenario& scenario);

}  // namespace tenon::apps
