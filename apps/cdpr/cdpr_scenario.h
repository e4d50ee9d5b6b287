#pragma once

#include <tenon/apps/common/report_scenario.h>
#include <tenon/apps/common/scenario_keys.h>
#include <tenon/apps/common/verdicts.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/faults/cdpr_faults.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/plants/model/attached_body.h>

namespace tenon::apps {

/// The sensors of a cable robot, but for the noise of pose sensor and inertial unit, which is the scenario's
/// `noise`.
struct CdprSensors {
  std::optional<Delayed<CableSensorsParams>> cables;  ///< empty: ideal
  Delayed<PoseSensorParams> pose;                     ///< residual errors of the calibration
  Delayed<ImuErrorsParams> imu;                       ///< errors that differ from unit to unit

  static FieldList Fields() {
    using S = CdprSensors;
    return {{"cables", &S::cables}, {"pose", &S::pose}, {"imu", &S::imu}};
  }
};

/// A cable robot's hardware, in files such as plants/hardware/cdpr/standard.yaml. Values that are not given
/// are those of ideal hardware.
struct CdprHardware {
  std::string description;
  WinchErrorsParams winches;
  JitteredDelayParams<CableVector> link{.delay = 0, .unit = "N"};  ///< computation and field bus, up to 1 s
  SlowOptions calculation;                                         ///< duration of a solve of the MPC
  CdprSensors sensors;

  static FieldList Fields() {
    using S = CdprHardware;
    return {{"description", &S::description},
            {"winches", &S::winches},
            {"link", &S::link},
            {"calculation", &S::calculation},
            {"sensors", &S::sensors}};
  }
  void Validate() const { Demand(link.delay <= 1, "link.delay_s must be at most 1 s"); }
};

/// Sets the hardware of `loop`, whose robot, rates and sensor noise must be set before: shipped hardware by
/// its name, a file, or one of these with changes, see LoadResource(). Throws ParameterError.
void SetHardware(const YamlFile& what, CdprLoopParams& loop);

enum class PathKind { kHold, kLine, kCircle, kSpline, kWaypoints, kFile };

/// The plane of a circle, and the axes between which it turns.
enum class CirclePlane { kXy, kXz, kYz };

/// Waypoint of the platform. The platform rests at the first and the last waypoint and wherever it dwells; it
/// passes through the others without stopping.
struct WaypointScenario {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< position of the CoM in W
  std::optional<Eigen::Vector3d> attitude_rad;  ///< roll, pitch, yaw; empty: those of the previous waypoint
  std::optional<double> travel_s;               ///< travel time from the previous waypoint
  /// Mean speed on the straight line from the previous waypoint; alternative to `travel_s`.
  std::optional<double> speed_m_per_s;
  double dwell_s = 0;  ///< time at rest at the waypoint

  static FieldList Fields() {
    return {Required("position_m", &WaypointScenario::position_m).In(Places()),
            {"attitude_rad", &WaypointScenario::attitude_rad},
            Field("travel_s", &WaypointScenario::travel_s).Positive(),
            Field("speed_m_per_s", &WaypointScenario::speed_m_per_s).Positive(),
            Field("dwell_s", &WaypointScenario::dwell_s).AtLeast(0)};
  }
};

/// The path of a platform, made from a PathScenario.
struct PlatformPath {
  Path position;
  std::optional<Path> attitude;  ///< roll, pitch, yaw [rad]; empty if the scenario gives none for the points
};

/// The path of the platform's CoM in W.
struct PathScenario {
  PathKind kind = PathKind::kCircle;      ///< shape of the path
  Eigen::Vector3d center_m{0, 0, 2};      ///< centre of the circle
  double radius_m = 0.5;                  ///< radius of the circle
  double period_s = 10;                   ///< duration of one turn of the circle
  double ramp_s = 5;                      ///< time in which the platform reaches the circle's speed
  CirclePlane plane = CirclePlane::kXy;   ///< plane of the circle; `xz` and `yz` for planar robots
  std::vector<Eigen::Vector3d> points_m;  ///< one point for a hold, two for a line, or those of a spline
  std::vector<double> times_s;            ///< times of the points of a line or a spline
  /// Constant roll, pitch and yaw, for robots with six or more cables; empty: those of the equilibria.
  std::optional<Eigen::Vector3d> attitude_rad;
  /// Roll, pitch and yaw at each point of a line or a spline along which the platform turns.
  std::vector<Eigen::Vector3d> attitudes_rad;
  std::vector<WaypointScenario> waypoints;  ///< waypoints of a path of kind `waypoints`
  /// CSV file of a path of kind `file`, with the columns t,x,y,z or t,x,y,z,roll,pitch,yaw in s, m, rad.
  std::optional<YamlFile> file;
  /// Desired tension of all cables. Among the tensions that hold a given attitude, the nearest are chosen.
  double tension_aim_N = 0;

  static FieldList Fields() {
    return {Required("kind", &PathScenario::kind),
            Field("center_m", &PathScenario::center_m).In(Places()),
            Field("radius_m", &PathScenario::radius_m).Positive(),
            Field("period_s", &PathScenario::period_s).Positive(),
            Field("ramp_s", &PathScenario::ramp_s).AtLeast(0),
            {"plane", &PathScenario::plane},
            Field("points_m", &PathScenario::points_m).In(Places()),
            {"times_s", &PathScenario::times_s},
            {"attitude_rad", &PathScenario::attitude_rad},
            {"attitudes_rad", &PathScenario::attitudes_rad},
            {"waypoints", &PathScenario::waypoints},
            {"file", &PathScenario::file},
            Field("tension_aim_N", &PathScenario::tension_aim_N).AtLeast(0)};
  }
  void Validate() const;      ///< throws ParameterError
  PlatformPath Make() const;  ///< throws ParameterError
};

/// PD control of the cable lengths, see CablePd. Empty gains are those of the profile.
struct PdScenario {
  std::optional<DiagonalGains> stiffness_N_per_m;  ///< K_p of the cable lengths
  std::optional<DiagonalGains> damping_N_s_per_m;  ///< K_d of the rates of the cable lengths
  Rate rate = CdprLoopParams().control_rate;       ///< sample rate of the controller

  static FieldList Fields() {
    return {Field("stiffness_N_per_m", &PdScenario::stiffness_N_per_m).Positive(),
            Field("damping_N_s_per_m", &PdScenario::damping_N_s_per_m).AtLeast(0),
            {"rate_hz", &PdScenario::rate}};
  }
};

/// Model predictive control of the platform, see CdprMpc. Empty horizon, steps and weights are those of the
/// profile.
struct MpcScenario {
  std::optional<double> horizon_s;        ///< length of the horizon
  std::optional<int> num_steps;           ///< number of steps of the horizon
  std::optional<CdprMpcWeights> weights;  ///< weights of the squared errors, per second of the horizon
  CdprMpcParams params;                   // but for horizon, steps, weights and path
  SlqOptions slq;
  double mass_error = 0;  ///< relative error of the mass in the model: 0.3 is 30 % too heavy
  /// Whether mpc_equilibrium estimates the load and uses it in its model and its reference.
  bool offset_free = true;

  static FieldList Fields() {
    using S = MpcScenario;
    return {Field("horizon_s", &S::horizon_s).Between(1e-3, 100),
            Field("num_steps", &S::num_steps).Between(1, 1000),
            {"rate_hz", &S::params, &CdprMpcParams::rate},
            {"command_rate_hz", &S::params, &CdprMpcParams::command_rate},
            {"weights", &S::weights},
            {"method", &S::slq, &SlqOptions::method},
            {"bounds", &S::slq, &SlqOptions::bounds},
            {"final_weight", &S::params, &CdprMpcParams::terminal},
            Field("clearance_m", &S::params, &CdprMpcParams::clearance).AtLeast(0),
            Field("cable_clearance_m", &S::params, &CdprMpcParams::cable_clearance).AtLeast(0),
            Field("mass_error", &S::mass_error).Above(-1).AtMost(100).Because("at -1 the model has no mass"),
            Field("max_fallbacks_in_a_row", &S::params, &CdprMpcParams::max_fallbacks_in_a_row).AtLeast(0),
            {"offset_free", &S::offset_free}};
  }
};

/// A load that hangs below the platform on a rope with the properties of the robot's cables, see HangingLoad.
struct HangingLoadScenario : HangingLoadParams {
  Vec<2> swing_m = Vec<2>::Zero();  ///< initial horizontal offset of the load

  static FieldList Fields() {
    return HangingLoadParams::Fields() + FieldList{{"swing_m", &HangingLoadScenario::swing_m}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Noise and rates of the pose sensor and the inertial unit: standard deviations along or about each axis.
struct NoiseScenario {
  PoseSensorParams pose;
  ImuParams imu = CdprLoopParams().imu;

  static FieldList Fields() {
    using S = NoiseScenario;
    return {
        Field("position_m", &S::pose, &PoseSensorParams::position_noise).AtLeast(0).Uniform(),
        Field("attitude_rad", &S::pose, &PoseSensorParams::attitude_noise).AtLeast(0).Uniform(),
        Field("angular_velocity_rad_per_s", &S::imu, &ImuParams::angular_velocity_noise).AtLeast(0).Uniform(),
        Field("acceleration_m_per_s2", &S::imu, &ImuParams::specific_force_noise).AtLeast(0).Uniform(),
        {"pose_rate_hz", &S::pose, &PoseSensorParams::rate},
        {"imu_rate_hz", &S::imu, &ImuParams::rate}};
  }
};

/// Estimate of the load on the platform, for offset-free controllers, see LoadEstimator. Empty bandwidths are
/// those of MakeLoadEstimator: for an MPC 20 rad/s, and 100 rad/s for the mass; for a PD 3 rad/s for both.
struct LoadEstimateScenario {
  std::optional<double> bandwidth_rad_per_s;       ///< bandwidth of the estimated load, except its mass
  std::optional<double> mass_bandwidth_rad_per_s;  ///< bandwidth of the load's estimated mass

  static FieldList Fields() {
    return {Field("bandwidth_rad_per_s", &LoadEstimateScenario::bandwidth_rad_per_s).Positive(),
            Field("mass_bandwidth_rad_per_s", &LoadEstimateScenario::mass_bandwidth_rad_per_s).Positive()};
  }
};

enum class CdprController {
  kMpcEquilibrium,  ///< MPC about the equilibrium tensions; offset-free unless mpc.offset_free is false
  kMpcZero,         ///< MPC of Morlando 2023, which minimises the tensions; not offset-free
  /// MPC of Morlando 2023 about the equilibrium tensions: no load estimate, roll-outs projected on the
  /// bounds, diagonal final weight, a step of the horizon and a command per solve, whatever `mpc` says about
  /// these.
  kMpcThesis,
  /// Linear-quadratic regulator about the path with the weights and the load estimate of the MPC: the MPC
  /// with a horizon of two periods, whose final weight is the cost of the infinite horizon.
  kLqr,
  kPd,             ///< PD on the cable lengths about the static equilibrium
  kPdFeedforward,  ///< PD with a feedforward of the platform's acceleration
  kPdOffsetFree,   ///< PD with a feedforward of the estimated load
};
constexpr bool IsMpc(CdprController controller) {
  return controller == CdprController::kMpcEquilibrium || controller == CdprController::kMpcZero ||
         controller == CdprController::kMpcThesis || controller == CdprController::kLqr;
}

/// Scenario of tenon-cdpr, read from a YAML file.
struct CdprScenario : CommonScenario {
  YamlFile robot{"cdpr_4"};  ///< a shipped robot, a YAML file, or one of these with changes
  double duration_s = 60;    ///< simulated time
  CdprController controller = CdprController::kPd;  ///< controller that commands the tensions
  PathScenario path;                                ///< path of the platform
  /// Gains for robots of all sizes, see CdprProfile; used where `pd` and `mpc` give none.
  YamlFile profile{"cable_robot"};
  PdScenario pd;    ///< gains of the PD controllers
  MpcScenario mpc;  ///< parameters of the MPCs
  LoadEstimateScenario load;
  bool known_pulleys = true;  ///< whether controllers and estimators model the pulleys of the robot
  Eigen::Vector3d start_offset_m{0, 0, 0};  ///< initial offset of the platform from the path
  Eigen::Vector3d start_turn_rad{0, 0, 0};  ///< initial offset of roll, pitch and yaw
  PayloadScheduleParams payload;
  std::vector<AttachedBody> attached;  ///< bodies on joints, missing from the controller's model
  /// Whether the controller measures the wrench of attached bodies on the platform, as by a force sensor
  /// under the base of an arm. Not with controller pd, which does not use the load.
  bool known_additions = false;
  std::vector<Gust> gusts;
  std::optional<HangingLoadScenario> hanging_load;
  NoiseScenario noise;
  /// Winches, sensors and the connection between them: shipped hardware, a YAML file, or {file: standard, …}
  /// with changes.
  YamlFile hardware{"ideal"};
  std::vector<CdprFault> faults;  ///< faults of signals, winches and cables, in the order of their insertion
  /// Source of the platform's acceleration; with attached bodies, always Simbody.
  Dynamics dynamics = Dynamics::kClosedForm;
  CdprIntegration integrator;
  double log_rate_hz = 200;                           ///< sample rate of signals.csv
  bool forbid_slack = CdprLoopParams().forbid_slack;  ///< whether a slack cable ends the run with exit code 3
  /// Largest tension of a cable over the largest tension of the winches; a higher tension ends the run with
  /// exit code 3.
  double max_tension_ratio = CdprLoopParams().max_tension_ratio;
  double cable_diameter_m = 0.005;  ///< distance below which two cables touch
  /// Tolerance of the path: deviations in position may reach this part of the path's length (of one turn of a
  /// circle), deviations in heading this part of half a turn. A run that exceeds it counts as not finished.
  double path_tolerance = 0.1;
  Task task;                       ///< task, without which the case is not finished
  std::optional<YamlText> custom;  ///< keys of a customised program, see Customisable

  static FieldList Fields() {
    return With({{"robot", &CdprScenario::robot},
                 Field("duration_s", &CdprScenario::duration_s).Positive(),
                 {"controller", &CdprScenario::controller},
                 Required("path", &CdprScenario::path),
                 {"profile", &CdprScenario::profile},
                 {"pd", &CdprScenario::pd},
                 {"mpc", &CdprScenario::mpc},
                 {"load", &CdprScenario::load},
                 {"known_pulleys", &CdprScenario::known_pulleys},
                 Field("start_offset_m", &CdprScenario::start_offset_m).In(Places()),
                 {"start_turn_rad", &CdprScenario::start_turn_rad},
                 {"payload", &CdprScenario::payload},
                 {"attached", &CdprScenario::attached},
                 {"known_additions", &CdprScenario::known_additions},
                 {"gusts", &CdprScenario::gusts},
                 {"hanging_load", &CdprScenario::hanging_load},
                 {"noise", &CdprScenario::noise},
                 {"hardware", &CdprScenario::hardware},
                 {"faults", &CdprScenario::faults},
                 {"dynamics", &CdprScenario::dynamics},
                 {"integrator", &CdprScenario::integrator},
                 Field("log_rate_hz", &CdprScenario::log_rate_hz).In(Rates()),
                 {"forbid_slack", &CdprScenario::forbid_slack},
                 Field("max_tension_ratio", &CdprScenario::max_tension_ratio).Between(1, 2),
                 Field("cable_diameter_m", &CdprScenario::cable_diameter_m).AtLeast(0),
                 Field("path_tolerance", &CdprScenario::path_tolerance).Positive(),
                 {"task", &CdprScenario::task},
                 {"custom", &CdprScenario::custom}});
  }
  void Validate() const;  ///< throws ParameterError
};

/// Returns the diagram's parameters for a scenario. Reads the robot's file and computes the equilibria along
/// the path. Throws KeyError, also for a path that leaves the workspace.
CdprLoopParams MakeLoopParams(const CdprScenario& scenario);
SimulatorOptions MakeSimulatorOptions(const CdprScenario& scenario);
/// Judges whether the platform follows its path. A live run is not judged.
PathVerdict MakePathVerdict(const CdprScenario& scenario, bool live);
/// A note if winches cannot pay out as fast as the platform moves; empty if they can. A winch in tension mode
/// with reel damping b pays out at dl/dt under the tension T if the motor's tension is T - b dl/dt. So
/// tensions must exist that hold the platform at rest and are higher than the smallest tension by b dl/dt.
std::string PayOutNote(const EquilibriumPath& equilibria);

/// The points of a path with their times.
struct PathTable {
  std::vector<double> times;               ///< [s]
  std::vector<Eigen::Vector3d> points;     ///< positions of the CoM in W [m]
  std::vector<Eigen::Vector3d> attitudes;  ///< roll, pitch, yaw [rad]; none, or one per point
};

/// Reads a path from a CSV file: a header, `t,x,y,z` or `t,x,y,z,roll,pitch,yaw`, then a row per point, in s,
/// m and rad. Throws ParameterError with file and line if the header has other columns, a row has too few or
/// too many values, a value is not a finite number, the times do not increase, or there are fewer than two
/// rows.
PathTable ReadPathFile(const std::string& file);

}  // namespace tenon::apps
