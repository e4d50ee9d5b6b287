#pragma once

#include <tenon/apps/cdpr/cdpr_hardware.h>
#include <tenon/apps/common/path_verdict.h>
#include <tenon/apps/common/report_scenario.h>
#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/faults/cdpr_faults.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/systems/framework/types/fields.h>

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

enum class PathKind { kHold, kLine, kCircle, kSpline, kWaypoints, kFile };
constexpr auto EnumNames(PathKind) {
  return std::array{Named{PathKind::kHold, "hold"},           Named{PathKind::kLine, "line"},
                    Named{PathKind::kCircle, "circle"},       Named{PathKind::kSpline, "spline"},
                    Named{PathKind::kWaypoints, "waypoints"}, Named{PathKind::kFile, "file"}};
}

/// A place on the platform's way, how it gets there, and how long it stays: it comes to rest where it dwells,
/// at the first and at the last, and passes through the others without stopping.
struct WaypointScenario {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< position of the CoM
  std::optional<Eigen::Vector3d> attitude_rad;           ///< roll, pitch, yaw; without: as before
  std::optional<double> travel_s;                        ///< time from the waypoint before; this
  std::optional<double> speed_m_per_s;                   ///< or this: on average, along a straight line
  double dwell_s = 0;                                    ///< how long it rests there

  static FieldList Fields() {
    return {Required("position_m", &WaypointScenario::position_m),
            {"attitude_rad", &WaypointScenario::attitude_rad},
            {"travel_s", &WaypointScenario::travel_s},
            {"speed_m_per_s", &WaypointScenario::speed_m_per_s},
            {"dwell_s", &WaypointScenario::dwell_s}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// The path and its duration, made from a path scenario.
struct PlatformPath {
  Path position;
  std::optional<Path> attitude;  ///< roll, pitch, yaw [rad], if they are given by place
};

/// The path of the platform's CoM, in the world.
struct PathScenario {
  PathKind kind = PathKind::kCircle;      ///< shape of the path
  Eigen::Vector3d center_m{0, 0, 2};      ///< centre of the circle
  double radius_m = 0.5;                  ///< radius of the circle
  double period_s = 10;                   ///< time of one turn
  double ramp_s = 5;                      ///< time in which the circle's speed is reached
  std::vector<Eigen::Vector3d> points_m;  ///< points of a hold (1), a line (2) or a spline
  std::vector<double> times_s;            ///< times of the points; a line and a spline need them
  /// Roll, pitch, yaw all along the path, for robots of six cables or more; else the equilibrium's.
  std::optional<Eigen::Vector3d> attitude_rad;
  /// Attitude at each of the points, for a line or a spline that turns the platform on its way.
  std::vector<Eigen::Vector3d> attitudes_rad;
  std::vector<WaypointScenario> waypoints;  ///< waypoints, for kind waypoints
  std::optional<YamlFile>
      file;  ///< CSV, for kind file, with columns t,x,y,z or t,x,y,z,roll,pitch,yaw in s, m, rad
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
            {"attitudes_rad", &PathScenario::attitudes_rad},
            {"waypoints", &PathScenario::waypoints},
            {"file", &PathScenario::file},
            {"tension_aim_N", &PathScenario::tension_aim_N}};
  }
  void Validate() const;      ///< throws ParameterError
  PlatformPath Make() const;  ///< throws ParameterError
};

struct PdScenario {
  double stiffness_N_per_m = 0;                         ///< K_p of the cables' lengths
  double damping_N_s_per_m = 0;                         ///< K_d of their rates
  double rate_hz = CdprLoopParams().control_rate.hz();  ///< rate of the controller

  static FieldList Fields() {
    return {Required("stiffness_N_per_m", &PdScenario::stiffness_N_per_m),
            Required("damping_N_s_per_m", &PdScenario::damping_N_s_per_m),
            {"rate_hz", &PdScenario::rate_hz}};
  }
  void Validate() const;  ///< throws ParameterError
};

struct MpcScenario {
  double horizon_s = CdprMpcParams().horizon;                  ///< how far it plans
  int num_steps = CdprMpcParams().num_steps;                   ///< number of steps of the horizon
  double rate_hz = CdprMpcParams().rate.hz();                  ///< rate of the solves
  double command_rate_hz = CdprMpcParams().command_rate.hz();  ///< rate of the feedback along a plan
  CdprMpcWeights weights;
  StepMethod method = SlqOptions().method;               ///< method that integrates the model
  SlqBounds bounds = SlqOptions().bounds;                ///< handling of the tension bounds in the solver
  TerminalCost final_weight = CdprMpcParams().terminal;  ///< diagonal: `weights` times a second
  double mass_error = 0;  ///< relative error of the model's mass: 0.3 is 30 % too heavy
  int max_fallbacks_in_a_row =
      CdprMpcParams().max_fallbacks_in_a_row;  ///< more failed solves than this end the run
  bool offset_free = true;  ///< mpc_equilibrium estimates the load, and uses it in model and reference

  static FieldList Fields() {
    return {{"horizon_s", &MpcScenario::horizon_s},
            {"num_steps", &MpcScenario::num_steps},
            {"rate_hz", &MpcScenario::rate_hz},
            {"command_rate_hz", &MpcScenario::command_rate_hz},
            Required("weights", &MpcScenario::weights),
            {"method", &MpcScenario::method},
            {"bounds", &MpcScenario::bounds},
            {"final_weight", &MpcScenario::final_weight},
            {"mass_error", &MpcScenario::mass_error},
            {"max_fallbacks_in_a_row", &MpcScenario::max_fallbacks_in_a_row},
            {"offset_free", &MpcScenario::offset_free}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A mass hung at the platform for part of the run; the controller does not know of it.
struct PayloadScenario {
  double mass_kg = 0;                                    ///< mass of the point
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< in the platform's frame, from its CoM
  double attach_s = 0;                                   ///< when it is hung there
  double release_s = 0;                                  ///< when it drops

  static FieldList Fields() {
    return {{"mass_kg", &PayloadScenario::mass_kg},
            {"position_m", &PayloadScenario::position_m},
            {"attach_s", &PayloadScenario::attach_s},
            {"release_s", &PayloadScenario::release_s}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A gust of wind on the platform, with the 1-cosine profile of Gusts.
struct GustScenario {
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();  ///< at its peak
  double start_s = 0;                                 ///< when it begins
  double duration_s = 1;                              ///< time from its beginning to its end

  static FieldList Fields() {
    return {Required("force_N", &GustScenario::force_N), Required("start_s", &GustScenario::start_s),
            Required("duration_s", &GustScenario::duration_s)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A load that swings under the platform, on a rope like the robot's cables, see HangingLoad.
struct HangingLoadScenario {
  double mass_kg = 0;                                      ///< mass of the load, a point mass
  double length_m = HangingLoadParams().length;            ///< length of the rope
  Eigen::Vector3d attachment_m = Eigen::Vector3d::Zero();  ///< in the platform's frame, from its CoM
  Eigen::Vector2d swing_m = Eigen::Vector2d::Zero();       ///< initial horizontal offset of the load

  static FieldList Fields() {
    return {Required("mass_kg", &HangingLoadScenario::mass_kg),
            Required("length_m", &HangingLoadScenario::length_m),
            {"attachment_m", &HangingLoadScenario::attachment_m},
            {"swing_m", &HangingLoadScenario::swing_m}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Noise of the sensors of pose and motion.
struct NoiseScenario {
  double position_m =
      PoseSensorParams().position_noise[0];  ///< standard deviation of the pose sensor, by axis
  double attitude_rad = PoseSensorParams().attitude_noise[0];  ///< standard deviation of the attitude
  double angular_velocity_rad_per_s =
      ImuParams().angular_velocity_noise[0];  ///< standard deviation of the gyroscope
  double acceleration_m_per_s2 = ImuParams().specific_force_noise[0];  ///< noise of the accelerometer
  double pose_rate_hz = PoseSensorParams().rate.hz();                  ///< rate of the pose sensor
  double imu_rate_hz = CdprLoopParams().imu.rate.hz();  ///< rate of gyroscope and accelerometer

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

/// How the load on the platform is estimated, for controllers that are offset-free; see LoadEstimator.
/// Without values the bandwidths are those of MakeLoadEstimator: 20 and 100 rad/s for an MPC, 3 and 3 for a
/// PD.
struct LoadEstimateScenario {
  std::optional<double> bandwidth_rad_per_s;       ///< bandwidth of the other estimates of the load
  std::optional<double> mass_bandwidth_rad_per_s;  ///< bandwidth of the estimate of the load's mass

  static FieldList Fields() {
    return {{"bandwidth_rad_per_s", &LoadEstimateScenario::bandwidth_rad_per_s},
            {"mass_bandwidth_rad_per_s", &LoadEstimateScenario::mass_bandwidth_rad_per_s}};
  }
};

enum class CdprController {
  kMpcEquilibrium,  ///< offset-free, unless mpc.offset_free says no
  kMpcZero,         ///< Morlando 2023: tensions as small as may be; knows of no load
  kPd,              ///< PD on the cable lengths, about those of the static equilibrium
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
  std::string app;                        ///< the app whose scenario this is
  std::string description;                ///< one line
  std::string case_name;                  ///< the run's name
  YamlFile robot{"cdpr_4"};               ///< a shipped robot, a file, or a shipped one with changes
  double duration_s = 60;                 ///< simulated time
  std::uint64_t seed = kRecommendedSeed;  ///< seed of all random streams
  CdprController controller = CdprController::kPd;  ///< controller that commands the tensions
  PathScenario path;                                ///< path of the platform
  PdScenario pd;                                    ///< gains of the controllers pd...
  std::optional<MpcScenario> mpc;                   ///< needed for the controllers mpc_...
  LoadEstimateScenario load;
  bool known_pulleys = true;  ///< the controllers and their estimators know the pulleys of the robot
  Eigen::Vector3d start_offset_m{0, 0, 0};  ///< initial offset of the platform from the path
  Eigen::Vector3d start_turn_rad{0, 0, 0};  ///< added to roll, pitch, yaw there
  PayloadScenario payload;
  std::vector<GustScenario> gusts;
  std::optional<HangingLoadScenario> hanging_load;
  NoiseScenario noise;
  /// Winches, sensors and the link between: a shipped one, a YAML file, or {file: standard, …} with what
  /// differs.
  YamlFile hardware{"ideal"};
  std::vector<CdprFault> faults;  ///< faults, in the order of their insertion
  CdprIntegration integrator;
  double log_rate_hz = 200;                           ///< rate of signals.csv
  bool forbid_slack = CdprLoopParams().forbid_slack;  ///< a slack cable ends the run, exit code 3
  double max_tension_ratio =
      CdprLoopParams().max_tension_ratio;  ///< so does one pulled harder than this times the winches' maximum
  double cable_diameter_m = 0.005;         ///< nearer than this two cables touch
  /// How far the platform may leave its path: in position by this part of the path's length (a circle's is
  /// one turn), in heading by this part of half a turn; beyond, the run is not finished.
  double path_tolerance = 0.1;
  ReportScenario report;  ///< contents of the report
  std::map<std::string, std::vector<double>>
      parameters;                  ///< Parameters of the diagram, by path, set at the start
  std::optional<YamlText> custom;  ///< keys of a program with blocks of its own, see Customisable

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
            {"known_pulleys", &CdprScenario::known_pulleys},
            {"start_offset_m", &CdprScenario::start_offset_m},
            {"start_turn_rad", &CdprScenario::start_turn_rad},
            {"payload", &CdprScenario::payload},
            {"gusts", &CdprScenario::gusts},
            {"hanging_load", &CdprScenario::hanging_load},
            {"noise", &CdprScenario::noise},
            {"hardware", &CdprScenario::hardware},
            {"faults", &CdprScenario::faults},
            {"integrator", &CdprScenario::integrator},
            {"log_rate_hz", &CdprScenario::log_rate_hz},
            {"forbid_slack", &CdprScenario::forbid_slack},
            {"max_tension_ratio", &CdprScenario::max_tension_ratio},
            {"cable_diameter_m", &CdprScenario::cable_diameter_m},
            {"path_tolerance", &CdprScenario::path_tolerance},
            {"report", &CdprScenario::report},
            {"parameters", &CdprScenario::parameters},
            {"custom", &CdprScenario::custom}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Parameters of the diagram for a scenario. Reads the robot, and finds the equilibria along the path, so
/// that a path outside the workspace is refused here, before any run.
CdprLoopParams MakeLoopParams(const CdprScenario& scenario);
SimulatorOptions MakeSimulatorOptions(const CdprScenario& scenario);
/// Whether the platform follows its path, which is not judged in a live run.
PathVerdict MakePathVerdict(const CdprScenario& scenario, bool live);
/// The keys of a scenario that do nothing in a run of `duration` [s], each with the reason.
std::vector<std::string> Notes(const CdprScenario& scenario, double duration);

}  // namespace tenon::apps
