#pragma once

#include <tenon/apps/common/report_scenario.h>
#include <tenon/apps/common/verdicts.h>
#include <tenon/controllers/legged/observers/legged_state_estimator.h>
#include <tenon/controllers/legged/planning/centroidal_mpc.h>
#include <tenon/controllers/legged/planning/com_planner.h>
#include <tenon/controllers/legged/planning/pacer.h>
#include <tenon/controllers/legged/planning/swing_planner.h>
#include <tenon/controllers/legged/planning/walk_schedule.h>
#include <tenon/diagrams/faults/legged_faults.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/plants/sensors/terrain_mapper.h>
#include <tenon/systems/io/slow.h>

namespace tenon::apps {

/// Means of the limits of all joints, to which the ratios of DriveRatings refer.
struct MeanLimits {
  explicit MeanLimits(const QuadrupedDescription& robot);
  double torque = 0, speed = 0;  ///< [N m], [rad/s]
};

/// Data of all drives. Torques are relative to those of the robot.
struct DriveRatings : DriveErrorsParams {
  /// Peak torque over rotor inertia, both at the joint; empty: from the robot's file.
  std::optional<double> rotor_acceleration;
  std::optional<double> friction_ratio;  ///< dry friction over peak torque; empty: from the robot's file
  /// Viscous friction at the speed limit over peak torque; empty: from the robot's file.
  std::optional<double> damping_ratio;
  std::optional<double> bandwidth;  ///< bandwidth of the torque; empty: ideal
  bool limit_speed = false;         ///< limits the torque by the torque-speed line

  static FieldList Fields() {
    using S = DriveRatings;
    return DriveErrorsParams::Fields() +
           FieldList{Field("rotor_acceleration_rad_per_s2", &S::rotor_acceleration).Positive(),
                     Field("friction_ratio", &S::friction_ratio).Between(0, 1),
                     Field("damping_ratio", &S::damping_ratio).Between(0, 1),
                     Field("bandwidth_hz", &S::bandwidth).Between(0.1, 1e6),
                     {"limit_speed", &S::limit_speed}};
  }
};

/// A quadruped's hardware, in files such as plants/hardware/legged/standard.yaml. Values that are not given
/// are those of ideal hardware.
struct QuadrupedHardware {
  std::string description;
  DriveRatings drives;
  JitteredDelayParams<Vec<12>> link{.delay = 0, .unit = "N m"};  ///< computation and field bus, up to 1 s
  SlowOptions calculation;                                       ///< duration of a solve of the MPC
  QuadrupedSensors sensors;

  static FieldList Fields() {
    using S = QuadrupedHardware;
    return {{"description", &S::description},
            {"drives", &S::drives},
            {"link", &S::link},
            {"calculation", &S::calculation},
            {"sensors", &S::sensors}};
  }
  void Validate() const { Demand(link.delay <= 1, "link.delay_s must be at most 1 s"); }
};

/// Changes to the sensors of a QuadrupedHardware.
using SensorChanges = YamlChanges<QuadrupedSensors, true>;

/// Reads shipped hardware, a file, or one with changes (see LoadResource), with `sensors` changed, for a
/// robot of this scale. Throws ParameterError.
QuadrupedHardware LoadHardware(const YamlFile& file, const Scale& scale, const SensorChanges& sensors = {});

/// Sets the hardware in a world whose robot is set. `rate` is the sample rate of the controller.
/// The duration of calculations goes to `mpc`; without predictive control, which is null, it is an error.
void SetHardware(const QuadrupedHardware& hardware, Rate rate, QuadrupedWorldParams& world,
                 SlowOptions* mpc = nullptr);
/// The noise in the model of a state estimator: that of the data sheets, with lower bounds above zero.
ContactAidedNoise BelievedNoise(const QuadrupedSensors& sensors);

/// The state that the walking controller reads.
enum class StateSource { kTrue, kEstimated };

/// The commanded walk, and the settings of the walking controller that a scenario may change.
struct WalkScenario {
  WalkScheduleParams path;     ///< commanded path and gaits
  YamlFile gaits{"standard"};  ///< a shipped table of gaits, a YAML file, or one of these with changes
  std::optional<PaceProperties>
      pace;  ///< adapts the timing of the gaits to the speed and limits the acceleration
  std::optional<CentroidalMpcProperties> mpc;       ///< plans CoM, trunk and footholds by predictive control
  std::optional<TerrainMapProperties> terrain_map;  ///< elevation map that the planners read; empty: none
  ComReference com_reference = ComPlannerParams().reference;  ///< planner of the CoM's path
  ZmpPlanParams zmp;                                          ///< parameters of ComReference::kZmpSpline
  TrajectoryProperties trajectory;                            ///< parameters of ComReference::kTrajectory
  StepProperties step;                                        ///< swing of the feet
  /// State that the controller reads; estimated: output of a LeggedStateEstimator that knows the noise of the
  /// sensors.
  StateSource state = StateSource::kTrue;
  /// Friction coefficient that the controller assumes; empty: that of the profile, 1 by default.
  std::optional<double> friction;
  double mass_error_ratio = 0;   ///< relative error of the masses in the controller's model: 0.3 is 30 % more
  ModelErrorParams model_error;  ///< random errors of each body in the controller's model, drawn by the seed
  double judged_from_s = 0;      ///< start of the time over which figures are computed
  /// Tolerance of the path: deviations in position may reach this part of the path's length, deviations in
  /// heading this part of half a turn. A run that exceeds it counts as not finished.
  double path_tolerance = 0.1;

  static FieldList Fields() {
    return {Required("path", &WalkScenario::path),
            {"gaits", &WalkScenario::gaits},
            {"pace", &WalkScenario::pace},
            {"mpc", &WalkScenario::mpc},
            {"terrain_map", &WalkScenario::terrain_map},
            {"com_reference", &WalkScenario::com_reference},
            {"zmp", &WalkScenario::zmp},
            {"trajectory", &WalkScenario::trajectory},
            {"step", &WalkScenario::step},
            {"state", &WalkScenario::state},
            Field("friction", &WalkScenario::friction).Positive(),
            Field("mass_error_ratio", &WalkScenario::mass_error_ratio)
                .Above(-1)
                .Because("at -1 the model has no mass"),
            {"model_error", &WalkScenario::model_error},
            Field("judged_from_s", &WalkScenario::judged_from_s).AtLeast(0),
            Field("path_tolerance", &WalkScenario::path_tolerance).Positive()};
  }
};

/// Limits of the trunk's pose beyond which a robot counts as fallen.
struct FallScenario {
  /// Minimum height of the trunk above the ground, relative to that in the nominal stance.
  double min_height_ratio = kFallHeightRatio;
  double max_tilt_rad = QuadrupedWorldParams().max_tilt;  ///< maximum tilt of the trunk
  /// Maximum height of the trunk above the ground, which only a robot that was thrown exceeds.
  double max_height_m = QuadrupedWorldParams().max_height;

  static FieldList Fields() {
    return {Field("min_height_ratio", &FallScenario::min_height_ratio)
                .AtLeast(0)
                .Below(1)
                .Because("at 1 the nominal stance would count as a fall"),
            Field("max_tilt_rad", &FallScenario::max_tilt_rad).Between(1e-3, std::numbers::pi),
            Field("max_height_m", &FallScenario::max_height_m).Positive()};
  }
};

/// Ranges of the commands in a live run. The default speeds are those of the shipped scenarios with the
/// standard gait.
struct LiveScenario {
  Vec<2> forward_m_per_s{-0.3, 0.4};     ///< minimum and maximum forward velocity
  Vec<2> sideways_m_per_s{-0.15, 0.15};  ///< minimum and maximum velocity to the left
  Vec<2> yaw_rad_per_s{-0.5, 0.5};       ///< minimum and maximum yaw rate
  double squat_m = 0.08;                 ///< depth of a squat
  double load_ratio = 0.4;               ///< maximum load on the trunk, relative to the robot's mass

  static FieldList Fields() {
    return {{"forward_m_per_s", &LiveScenario::forward_m_per_s},
            {"sideways_m_per_s", &LiveScenario::sideways_m_per_s},
            {"yaw_rad_per_s", &LiveScenario::yaw_rad_per_s},
            Field("squat_m", &LiveScenario::squat_m).AtLeast(0),
            Field("load_ratio", &LiveScenario::load_ratio).Positive()};
  }
  void Validate() const;  ///< throws ParameterError
};

enum class Part { kTrunk, kFrontLeft, kFrontRight, kRearLeft, kRearRight };

/// A force on the robot for some time: constant, or a sine of the time since its start if a frequency is
/// given.
struct ForceScenario {
  Part on = Part::kTrunk;                             ///< body on which the force acts
  double height = 0.5;                                ///< point on a leg: 0 the foot, 0.5 the knee, 1 the hip
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();  ///< force in W
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();  ///< torque in W
  double factor = 1;                                     ///< factor of force and torque
  double turn_rad = 0;                                   ///< rotation of force and torque about the vertical
  double start_s = 0;                                    ///< time at which the force sets in
  double duration_s = 0;                                 ///< duration of the force
  double frequency_rad_per_s = 0;                        ///< frequency of a sine; 0: constant

  static FieldList Fields() {
    return {{"on", &ForceScenario::on},
            Field("height", &ForceScenario::height).Between(0, 1),
            {"force_N", &ForceScenario::force_N},
            {"torque_N_m", &ForceScenario::torque_N_m},
            {"factor", &ForceScenario::factor},
            {"turn_rad", &ForceScenario::turn_rad},
            {"start_s", &ForceScenario::start_s},
            Required("duration_s", &ForceScenario::duration_s).AtLeast(0),
            Field("frequency_rad_per_s", &ForceScenario::frequency_rad_per_s).AtLeast(0)};
  }
};

/// The keys that tenon-quadruped and tenon-guide-dog share.
struct LeggedScenario : CommonScenario {
  YamlFile robot{"dogbot"};          ///< a shipped robot, a YAML file, or one of these with changes
  std::optional<double> duration_s;  ///< simulated time; empty: until 1 s after the walk, or 10 s without one
  /// Gains of the walking controller: a shipped profile, a YAML file, or {file: standard, …} with changes.
  YamlFile profile{"standard"};
  TerrainParams terrain;              ///< slope, friction and boxes of the ground
  std::vector<ForceScenario> forces;  ///< forces on trunk and legs
  std::vector<LeggedFault> faults;    ///< faults of signals and joints
  /// Drives, sensors and the connection between them: shipped hardware, a YAML file, or {file: standard, …}
  /// with changes.
  YamlFile hardware{"ideal"};
  SensorChanges sensors;  ///< overrides the sensors of `hardware`
  FallScenario fall;
  LiveScenario live;
  /// Whether the torque-speed line limits the torque of the drives. If not, a run that exceeds the line
  /// counts as not finished.
  bool limit_speed = QuadrupedPlantParams().limit_speed;
  /// Source of the accelerations; with attached bodies, always Simbody.
  Dynamics dynamics = Dynamics::kClosedForm;
  LeggedIntegration integrator;
  /// Whether forces, loads, steps and blocks are given for DogBot and scaled to the robot, see ScaledToRobot.
  bool scale_forces = false;
  std::optional<YamlText> custom;  ///< keys of a customised program, see Customisable

  static FieldList Fields() {
    using S = LeggedScenario;
    return With({{"robot", &S::robot},
                 Field("duration_s", &S::duration_s).Positive(),
                 {"profile", &S::profile},
                 {"terrain", &S::terrain},
                 {"forces", &S::forces},
                 {"faults", &S::faults},
                 {"hardware", &S::hardware},
                 {"sensors", &S::sensors},
                 {"fall", &S::fall},
                 {"live", &S::live},
                 {"limit_speed", &S::limit_speed},
                 {"dynamics", &S::dynamics},
                 {"integrator", &S::integrator},
                 {"scale_forces", &S::scale_forces},
                 {"custom", &S::custom}});
  }
};

/// Judges whether a walk follows its path. A live run is not judged.
PathVerdict MakePathVerdict(const WalkScenario& walk, bool live);
/// Returns the time at which the walk ends [s]. Throws KeyError for a path that cannot be walked.
double EndOfWalk(const WalkScenario& walk);
/// Returns the options for a diagram that holds `plant`.
SimulatorOptions MakeSimulatorOptions(const LeggedScenario& scenario, const QuadrupedPlant& plant);
/// Returns robot, duration and seed in one line.
std::string Describe(const LeggedScenario& scenario, double duration);

}  // namespace tenon::apps
