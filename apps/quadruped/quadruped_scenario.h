#pragma once

#include <tenon/apps/common/path_verdict.h>
#include <tenon/apps/common/report_scenario.h>
#include <tenon/apps/quadruped/quadruped_faults.h>
#include <tenon/apps/quadruped/quadruped_hardware.h>
#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/plants/model/model_error.h>
#include <tenon/systems/framework/types/fields.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tenon::apps {

/// Without gains, those of MakeJointPd: K_p = 3.886 m g l per rad, K_d = 0.3099 m g l t, see RobotScale.
struct JointPdScenario {
  std::optional<double> stiffness_N_m_per_rad;  ///< K_p of the joints' angles; without: 3.886 m g l
  std::optional<double> damping_N_m_s_per_rad;  ///< K_d of their speeds; without: 0.31 m g l sqrt(l / g)
  bool gravity_compensation =
      JointPdParams().gravity_compensation;    ///< the torques that hold the weight are added
  double rate_hz = JointPdParams().rate.hz();  ///< of the controller

  static FieldList Fields() {
    return {{"stiffness_N_m_per_rad", &JointPdScenario::stiffness_N_m_per_rad},
            {"damping_N_m_s_per_rad", &JointPdScenario::damping_N_m_s_per_rad},
            {"gravity_compensation", &JointPdScenario::gravity_compensation},
            {"rate_hz", &JointPdScenario::rate_hz}};
  }
  void Validate() const;  ///< throws ParameterError
  JointPdParams For(const QuadrupedDescription& robot) const;
};

/// What the walking controller knows of the robot's pose and motion.
enum class StateSource { kTrue, kEstimated };
constexpr auto EnumNames(StateSource) {
  return std::array{Named{StateSource::kTrue, "true"}, Named{StateSource::kEstimated, "estimated"}};
}

/// What the walking robot is to do, and what the user chooses of the way it does that.
struct WalkScenario {
  WalkScheduleParams path;     ///< where it goes, and by which gaits
  YamlFile gaits{"standard"};  ///< a shipped table, a file, or one with what differs
  ComReference com_reference = ComPlannerParams().reference;  ///< how the CoM's path is planned
  ZmpPlanParams zmp;                                          ///< of ComReference::kZmpSpline
  StepProperties step;                                        ///< how the feet swing
  StateSource state =
      StateSource::kTrue;  ///< estimated: by a LeggedStateEstimator that knows the sensors' noise
  std::optional<double>
      friction;                  ///< that the controller counts on; without: the profile's, 1 unless it says
  double mass_error_ratio = 0;   ///< 0.3: the controller believes in masses 30 % too large
  ModelErrorParams model_error;  ///< of each body's data in what the controller believes, drawn by the seed
  double judged_from_s = 0;      ///< figures count from here
  /// How far the robot may leave its path: in position by this part of the path's length, in heading by this
  /// part of half a turn; beyond, the run is not finished.
  double path_tolerance = 0.2;

  static FieldList Fields() {
    return {Required("path", &WalkScenario::path),
            {"gaits", &WalkScenario::gaits},
            {"com_reference", &WalkScenario::com_reference},
            {"zmp", &WalkScenario::zmp},
            {"step", &WalkScenario::step},
            {"state", &WalkScenario::state},
            {"friction", &WalkScenario::friction},
            {"mass_error_ratio", &WalkScenario::mass_error_ratio},
            {"model_error", &WalkScenario::model_error},
            {"judged_from_s", &WalkScenario::judged_from_s},
            {"path_tolerance", &WalkScenario::path_tolerance}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Runs of one scenario with its first force at several instants and in several directions around the
/// vertical: `phases` instants, evenly over `period_s` from the force's start on.
struct SweepScenario {
  int phases = 8;       ///< instants
  double period_s = 0;  ///< over which they are spread, from the force's start on
  int directions = 8;   ///< around the vertical

  static FieldList Fields() {
    return {{"phases", &SweepScenario::phases},
            Required("period_s", &SweepScenario::period_s),
            {"directions", &SweepScenario::directions}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// When a robot counts as fallen.
struct FallScenario {
  double min_height_ratio =
      kFallHeightRatio;  ///< of the trunk above the ground, to that in the nominal stance
  double max_tilt_rad = QuadrupedWorldParams().max_tilt;  ///< of the trunk
  double max_height_m =
      QuadrupedWorldParams()
          .max_height;  ///< of the trunk above the ground: a robot that is higher was thrown

  static FieldList Fields() {
    return {{"min_height_ratio", &FallScenario::min_height_ratio},
            {"max_tilt_rad", &FallScenario::max_tilt_rad},
            {"max_height_m", &FallScenario::max_height_m}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// What can be ordered in a live run; as large as the shipped scenarios walk at the standard gait.
struct LiveScenario {
  Vec<2> forward_m_per_s{-0.3, 0.4};     ///< least and largest
  Vec<2> sideways_m_per_s{-0.15, 0.15};  ///< least and largest, to the left
  Vec<2> yaw_rad_per_s{-0.5, 0.5};       ///< least and largest
  double squat_m = 0.08;                 ///< how far the trunk sinks
  double load_ratio = 0.4;               ///< of the largest load on the trunk, to the robot's mass

  static FieldList Fields() {
    return {{"forward_m_per_s", &LiveScenario::forward_m_per_s},
            {"sideways_m_per_s", &LiveScenario::sideways_m_per_s},
            {"yaw_rad_per_s", &LiveScenario::yaw_rad_per_s},
            {"squat_m", &LiveScenario::squat_m},
            {"load_ratio", &LiveScenario::load_ratio}};
  }
  void Validate() const;  ///< throws ParameterError
};

enum class Part { kTrunk, kFrontLeft, kFrontRight, kRearLeft, kRearRight };
constexpr auto EnumNames(Part) {
  return std::array{Named{Part::kTrunk, "trunk"}, Named{Part::kFrontLeft, "front_left"},
                    Named{Part::kFrontRight, "front_right"}, Named{Part::kRearLeft, "rear_left"},
                    Named{Part::kRearRight, "rear_right"}};
}

/// A constant force, or a sine of the time since its start if there is a frequency.
struct ForceScenario {
  Part on = Part::kTrunk;                                ///< where it acts
  double height = 0.5;                                   ///< on a leg: 0 the foot, 0.5 the knee, 1 the hip
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();     ///< in W
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();  ///< in W
  double factor = 1;                                     ///< of force and torque
  double turn_rad = 0;                                   ///< both turned by this about the vertical
  double start_s = 0;                                    ///< when it sets in
  double duration_s = 0;                                 ///< how long it lasts
  double frequency_rad_per_s = 0;                        ///< of a sine; 0: constant

  static FieldList Fields() {
    return {{"on", &ForceScenario::on},
            {"height", &ForceScenario::height},
            {"force_N", &ForceScenario::force_N},
            {"torque_N_m", &ForceScenario::torque_N_m},
            {"factor", &ForceScenario::factor},
            {"turn_rad", &ForceScenario::turn_rad},
            {"start_s", &ForceScenario::start_s},
            Required("duration_s", &ForceScenario::duration_s),
            {"frequency_rad_per_s", &ForceScenario::frequency_rad_per_s}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A force that changes every period, see RandomForce.
struct RandomForceScenario {
  bool on_trunk = false;  ///< else on a leg, another one each time
  double lower_N = 0;     ///< least strength
  double upper_N = 0;     ///< greatest strength
  double period_s = 2;    ///< between changes

  static FieldList Fields() {
    return {{"on_trunk", &RandomForceScenario::on_trunk},
            Required("lower_N", &RandomForceScenario::lower_N),
            Required("upper_N", &RandomForceScenario::upper_N),
            {"period_s", &RandomForceScenario::period_s}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// How a load slides, see SlidingLoad.
struct SlideScenario {
  Eigen::Vector2d reach_m = SlidingLoadParams().reach;  ///< to either side along x and y
  double friction = SlidingLoadParams().friction;       ///< coefficient between load and trunk

  static FieldList Fields() {
    return {{"reach_m", &SlideScenario::reach_m}, {"friction", &SlideScenario::friction}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A uniform box on the trunk for the whole run; the controller does not know of it.
struct TrunkLoadScenario {
  double mass_kg = 0;                                    ///< of the box
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< of its centre in the trunk's frame
  Eigen::Vector3d edges_m = Eigen::Vector3d::Zero();     ///< lengths of its edges
  std::optional<SlideScenario> slides;                   ///< it lies on the trunk; without: it is fixed there

  static FieldList Fields() {
    return {{"mass_kg", &TrunkLoadScenario::mass_kg},
            {"position_m", &TrunkLoadScenario::position_m},
            {"edges_m", &TrunkLoadScenario::edges_m},
            {"slides", &TrunkLoadScenario::slides}};
  }
  void Validate() const;  ///< throws ParameterError
  RigidInertia Make() const;
};

/// A run of tenon-quadruped, as its YAML file says it.
struct QuadrupedScenario {
  std::string app;                        ///< the app whose scenario this is
  std::string description;                ///< one line
  std::string case_name;                  ///< the run's name
  YamlFile robot{"dogbot"};               ///< a shipped robot, a file, or one with what differs
  std::optional<double> duration_s;       ///< without: 10 s of standing, or one second longer than the walk
  std::uint64_t seed = kRecommendedSeed;  ///< of all random streams
  double start_height_m = 0;          ///< of the feet above the plane's origin, at rest in the nominal stance
  TerrainParams terrain;              ///< the ground
  std::optional<JointPdScenario> pd;  ///< either stands by this
  std::optional<WalkScenario> walk;   ///< or walks
  std::optional<ObserverKind> observer;  ///< instead of the profile's
  /// The tuning of the walking controller: a shipped one, a YAML file, or {file: standard, …} with what
  /// differs.
  YamlFile profile{"standard"};
  /// Drives, sensors and the link between: a shipped one, a YAML file, or {file: standard, …} with what
  /// differs.
  YamlFile hardware{"ideal"};
  SensorScenario sensors;                          ///< goes before what the hardware says
  std::vector<ForceScenario> forces;               ///< on trunk and legs
  std::vector<RandomForceScenario> random_forces;  ///< that change every so often
  TrunkLoadScenario payload;
  std::vector<LeggedFault> faults;     ///< what breaks, and when
  std::optional<SweepScenario> sweep;  ///< one scenario at many instants and in many directions
  std::vector<ObserverKind> compare;   ///< what --compare runs; empty: all
  FallScenario fall;
  LiveScenario live;
  bool limit_speed =
      QuadrupedPlantParams()
          .limit_speed;  ///< the drives' torque falls with speed; without, no verdict is good that needs more
  LeggedIntegration integrator;
  bool scale_forces = false;  ///< forces, loads, steps and blocks are DogBot's, see ScaledToRobot
  double log_rate_hz = 200;   ///< of signals.csv
  ReportScenario report;      ///< what the report shows
  std::map<std::string, std::vector<double>> parameters;  ///< of the diagram, by path: set at the start

  static FieldList Fields() {
    return {Required("app", &QuadrupedScenario::app),
            {"description", &QuadrupedScenario::description},
            Required("case", &QuadrupedScenario::case_name),
            {"robot", &QuadrupedScenario::robot},
            {"duration_s", &QuadrupedScenario::duration_s},
            {"seed", &QuadrupedScenario::seed},
            {"start_height_m", &QuadrupedScenario::start_height_m},
            {"terrain", &QuadrupedScenario::terrain},
            {"pd", &QuadrupedScenario::pd},
            {"walk", &QuadrupedScenario::walk},
            {"observer", &QuadrupedScenario::observer},
            {"profile", &QuadrupedScenario::profile},
            {"hardware", &QuadrupedScenario::hardware},
            {"sensors", &QuadrupedScenario::sensors},
            {"forces", &QuadrupedScenario::forces},
            {"random_forces", &QuadrupedScenario::random_forces},
            {"payload", &QuadrupedScenario::payload},
            {"faults", &QuadrupedScenario::faults},
            {"sweep", &QuadrupedScenario::sweep},
            {"compare", &QuadrupedScenario::compare},
            {"fall", &QuadrupedScenario::fall},
            {"live", &QuadrupedScenario::live},
            {"limit_speed", &QuadrupedScenario::limit_speed},
            {"integrator", &QuadrupedScenario::integrator},
            {"scale_forces", &QuadrupedScenario::scale_forces},
            {"log_rate_hz", &QuadrupedScenario::log_rate_hz},
            {"report", &QuadrupedScenario::report},
            {"parameters", &QuadrupedScenario::parameters}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// How a robot compares with DogBot, for which the thesis gives forces and blocks.
struct SizeRatio {
  double weight = 1, length = 1;  ///< of the robot over that of DogBot; length: of a leg
};
/// 1 and 1 unless the scenario scales its forces.
SizeRatio RatioOf(const QuadrupedScenario& scenario);
/// The scenario for its robot, if scale_forces: forces and the payload's mass times the ratio of the weights,
/// heights, sizes and gaps of blocks, lengths of steps and of the payload times that of the legs, torques
/// times both. Times, speeds, the path and where blocks lie stay.
QuadrupedScenario ScaledToRobot(QuadrupedScenario scenario);

/// Whether a walk follows its path, which is not judged in a live run.
PathVerdict MakePathVerdict(const WalkScenario& walk, bool live);
/// The keys of a scenario that do nothing in a run of `duration` [s], each with the reason.
std::vector<std::string> Notes(const QuadrupedScenario& scenario, double duration);
/// The entries of a list of forces that never act, each with the reason.
void AddNotes(const std::vector<ForceScenario>& forces, double duration, std::vector<std::string>& notes);

/// How long it runs [s].
double Duration(const QuadrupedScenario& scenario);
/// What the diagrams need to know of a scenario; read the robot and the controller's files.
QuadrupedStandParams MakeStandParams(const QuadrupedScenario& scenario);
QuadrupedWalkParams MakeWalkParams(const QuadrupedScenario& scenario);
/// The scenarios of a sweep, by name.
std::vector<std::pair<std::string, QuadrupedScenario>> SweepOf(const QuadrupedScenario& scenario);
/// For a diagram that holds a QuadrupedWorld named "loop.world".
SimulatorOptions MakeSimulatorOptions(const QuadrupedScenario& scenario);

}  // namespace tenon::apps
