#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <tenon/apps/common/outputs.h>
#include <tenon/controllers/legged/profile/locomotion_profile.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/systems/framework/fields.h>
#include <tenon/systems/simulation/simulator_options.h>

namespace tenon::apps {

struct JointPdScenario {
  double stiffness_N_m_per_rad = 0;
  double damping_N_m_s_per_rad = 0;
  bool gravity_compensation = true;
  double rate_hz = 1000;

  static constexpr auto Fields() {
    return std::tuple{Required("stiffness_N_m_per_rad", &JointPdScenario::stiffness_N_m_per_rad),
                      Required("damping_N_m_s_per_rad", &JointPdScenario::damping_N_m_s_per_rad),
                      Field{"gravity_compensation", &JointPdScenario::gravity_compensation},
                      Field{"rate_hz", &JointPdScenario::rate_hz}};
  }
};

/// What the walking controller knows of the robot's pose and motion.
enum class StateSource { kTrue, kEstimated };
constexpr auto EnumNames(StateSource) {
  return std::array{std::pair{StateSource::kTrue, "true"}, std::pair{StateSource::kEstimated, "estimated"}};
}

/// What the walking robot is to do, and what the user chooses of the way it does that.
struct WalkScenario {
  WalkScheduleParams path;
  std::string gaits = "standard";  ///< a shipped table or a YAML file
  ComReference com_reference = ComReference::kPendulum;
  ZmpPlanParams zmp;  ///< of ComReference::kZmpSpline
  StepProperties step;
  StateSource state =
      StateSource::kTrue;       ///< estimated: by a LeggedStateEstimator that knows the sensors' noise
  double friction = 1;          ///< that the controller counts on
  double mass_error_ratio = 0;  ///< 0.3: the controller believes in masses 30 % too large
  double judged_from_s = 0;     ///< figures count from here

  static constexpr auto Fields() {
    return std::tuple{Required("path", &WalkScenario::path),
                      Field{"gaits", &WalkScenario::gaits},
                      Field{"com_reference", &WalkScenario::com_reference},
                      Field{"zmp", &WalkScenario::zmp},
                      Field{"step", &WalkScenario::step},
                      Field{"state", &WalkScenario::state},
                      Field{"friction", &WalkScenario::friction},
                      Field{"mass_error_ratio", &WalkScenario::mass_error_ratio},
                      Field{"judged_from_s", &WalkScenario::judged_from_s}};
  }
};

/// Runs of one scenario with its first force at several instants and in several directions around the
/// vertical: `phases` instants, evenly over `period_s` from the force's start on.
struct SweepScenario {
  int phases = 8;
  double period_s = 0;
  int directions = 8;

  static constexpr auto Fields() {
    return std::tuple{Field{"phases", &SweepScenario::phases}, Required("period_s", &SweepScenario::period_s),
                      Field{"directions", &SweepScenario::directions}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// When a robot counts as fallen.
struct FallScenario {
  double min_height_ratio = 0.5;  ///< of the trunk above the ground, to that in the nominal stance
  double max_tilt_rad = 1;

  static constexpr auto Fields() {
    return std::tuple{Field{"min_height_ratio", &FallScenario::min_height_ratio},
                      Field{"max_tilt_rad", &FallScenario::max_tilt_rad}};
  }
};

/// One standard deviation of white noise, and a constant that all samples carry; every sensor draws from a
/// stream of its own, which follows from the run's seed and the sensor's name.
struct EncoderScenario {
  double rate_hz = 1000;
  double angle_noise_rad = 0;
  double angle_bias_rad = 0;  ///< the same at all joints
  double speed_noise_rad_per_s = 0;
  double speed_bias_rad_per_s = 0;

  static constexpr auto Fields() {
    return std::tuple{Field{"rate_hz", &EncoderScenario::rate_hz},
                      Field{"angle_noise_rad", &EncoderScenario::angle_noise_rad},
                      Field{"angle_bias_rad", &EncoderScenario::angle_bias_rad},
                      Field{"speed_noise_rad_per_s", &EncoderScenario::speed_noise_rad_per_s},
                      Field{"speed_bias_rad_per_s", &EncoderScenario::speed_bias_rad_per_s}};
  }
};

/// The noise grows with the signal: 0.1 is 10 % of it.
struct TorqueSensorScenario {
  double rate_hz = 1000;
  double noise_ratio = 0;
  double bias_N_m = 0;  ///< the same at all joints

  static constexpr auto Fields() {
    return std::tuple{Field{"rate_hz", &TorqueSensorScenario::rate_hz},
                      Field{"noise_ratio", &TorqueSensorScenario::noise_ratio},
                      Field{"bias_N_m", &TorqueSensorScenario::bias_N_m}};
  }
};

/// The noise grows with the signal: 0.1 is 10 % of it.
struct FootForceSensorScenario {
  double rate_hz = 1000;
  double noise_ratio = 0;
  double bias_N = 0;  ///< the same in all components of all feet

  static constexpr auto Fields() {
    return std::tuple{Field{"rate_hz", &FootForceSensorScenario::rate_hz},
                      Field{"noise_ratio", &FootForceSensorScenario::noise_ratio},
                      Field{"bias_N", &FootForceSensorScenario::bias_N}};
  }
};

struct ImuScenario {
  double rate_hz = 1000;
  double angular_velocity_noise_rad_per_s = 0;
  Eigen::Vector3d angular_velocity_bias_rad_per_s = Eigen::Vector3d::Zero();  ///< in the trunk's frame
  double acceleration_noise_m_per_s2 = 0;
  Eigen::Vector3d acceleration_bias_m_per_s2 = Eigen::Vector3d::Zero();  ///< in the trunk's frame

  static constexpr auto Fields() {
    return std::tuple{
        Field{"rate_hz", &ImuScenario::rate_hz},
        Field{"angular_velocity_noise_rad_per_s", &ImuScenario::angular_velocity_noise_rad_per_s},
        Field{"angular_velocity_bias_rad_per_s", &ImuScenario::angular_velocity_bias_rad_per_s},
        Field{"acceleration_noise_m_per_s2", &ImuScenario::acceleration_noise_m_per_s2},
        Field{"acceleration_bias_m_per_s2", &ImuScenario::acceleration_bias_m_per_s2}};
  }
};

struct SensorScenario {
  EncoderScenario encoders;
  TorqueSensorScenario torque;
  FootForceSensorScenario foot_force;
  ImuScenario imu;

  static constexpr auto Fields() {
    return std::tuple{Field{"encoders", &SensorScenario::encoders}, Field{"torque", &SensorScenario::torque},
                      Field{"foot_force", &SensorScenario::foot_force}, Field{"imu", &SensorScenario::imu}};
  }
};

enum class Part { kTrunk, kFrontLeft, kFrontRight, kRearLeft, kRearRight };
constexpr auto EnumNames(Part) {
  return std::array{std::pair{Part::kTrunk, "trunk"}, std::pair{Part::kFrontLeft, "front_left"},
                    std::pair{Part::kFrontRight, "front_right"}, std::pair{Part::kRearLeft, "rear_left"},
                    std::pair{Part::kRearRight, "rear_right"}};
}

/// A constant force, or a sine of the time since its start if there is a frequency.
struct ForceScenario {
  Part on = Part::kTrunk;
  double height = 0.5;  ///< on a leg: 0 the foot, 0.5 the knee, 1 the hip
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_N_m = Eigen::Vector3d::Zero();
  double start_s = 0;
  double duration_s = 0;
  double frequency_rad_per_s = 0;

  static constexpr auto Fields() {
    return std::tuple{Field{"on", &ForceScenario::on},
                      Field{"height", &ForceScenario::height},
                      Field{"force_N", &ForceScenario::force_N},
                      Field{"torque_N_m", &ForceScenario::torque_N_m},
                      Field{"start_s", &ForceScenario::start_s},
                      Required("duration_s", &ForceScenario::duration_s),
                      Field{"frequency_rad_per_s", &ForceScenario::frequency_rad_per_s}};
  }
};

/// A force that changes every period, see RandomForce.
struct RandomForceScenario {
  bool on_trunk = false;
  double lower_N = 0;
  double upper_N = 0;
  double period_s = 2;

  static constexpr auto Fields() {
    return std::tuple{Field{"on_trunk", &RandomForceScenario::on_trunk},
                      Required("lower_N", &RandomForceScenario::lower_N),
                      Required("upper_N", &RandomForceScenario::upper_N),
                      Field{"period_s", &RandomForceScenario::period_s}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A uniform box on the trunk for the whole run; the controller does not know of it.
struct TrunkLoadScenario {
  double mass_kg = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< of its centre in the trunk's frame
  Eigen::Vector3d edges_m = Eigen::Vector3d::Zero();

  static constexpr auto Fields() {
    return std::tuple{Field{"mass_kg", &TrunkLoadScenario::mass_kg},
                      Field{"position_m", &TrunkLoadScenario::position_m},
                      Field{"edges_m", &TrunkLoadScenario::edges_m}};
  }
  RigidInertia Make() const;
};

/// What QuadrupedPlant recommends, and how far it goes.
struct LeggedIntegratorScenario {
  int order = 2;
  double rtol = 1e-2;
  double atol_position = 1e-4;  ///< [m, rad]
  double atol_velocity = 1e-2;  ///< [m/s, rad/s]
  double atol_bristles = 1e-6;  ///< [m]

  static constexpr auto Fields() {
    return std::tuple{Field{"order", &LeggedIntegratorScenario::order},
                      Field{"rtol", &LeggedIntegratorScenario::rtol},
                      Field{"atol_position", &LeggedIntegratorScenario::atol_position},
                      Field{"atol_velocity", &LeggedIntegratorScenario::atol_velocity},
                      Field{"atol_bristles", &LeggedIntegratorScenario::atol_bristles}};
  }
};

/// A run of tenon-quadruped, as its YAML file says it.
struct QuadrupedScenario {
  std::string app;
  std::string description;
  std::string case_name;
  std::string robot = "dogbot";      ///< a shipped robot or a YAML file
  std::optional<double> duration_s;  ///< without: 10 s of standing, or one second longer than the walk
  std::uint64_t seed = 1;
  double start_height_m = 0;  ///< of the feet above the plane's origin, at rest in the nominal stance
  TerrainParams terrain;
  std::optional<JointPdScenario> pd;     ///< either stands by this
  std::optional<WalkScenario> walk;      ///< or walks
  std::optional<ObserverKind> observer;  ///< instead of the profile's
  std::string profile = "standard";  ///< the tuning of the walking controller: a shipped one or a YAML file
  SensorScenario sensors;
  std::vector<ForceScenario> forces;
  std::vector<RandomForceScenario> random_forces;
  TrunkLoadScenario payload;
  std::optional<SweepScenario> sweep;
  std::vector<ObserverKind> compare;  ///< what --compare runs; empty: all
  FallScenario fall;
  bool limit_speed = false;  ///< the drives' torque falls with speed
  LeggedIntegratorScenario integrator;
  double log_rate_hz = 200;
  ReportScenario report;

  static constexpr auto Fields() {
    return std::tuple{Required("app", &QuadrupedScenario::app),
                      Field{"description", &QuadrupedScenario::description},
                      Required("case", &QuadrupedScenario::case_name),
                      Field{"robot", &QuadrupedScenario::robot},
                      Field{"duration_s", &QuadrupedScenario::duration_s},
                      Field{"seed", &QuadrupedScenario::seed},
                      Field{"start_height_m", &QuadrupedScenario::start_height_m},
                      Field{"terrain", &QuadrupedScenario::terrain},
                      Field{"pd", &QuadrupedScenario::pd},
                      Field{"walk", &QuadrupedScenario::walk},
                      Field{"observer", &QuadrupedScenario::observer},
                      Field{"profile", &QuadrupedScenario::profile},
                      Field{"sensors", &QuadrupedScenario::sensors},
                      Field{"forces", &QuadrupedScenario::forces},
                      Field{"random_forces", &QuadrupedScenario::random_forces},
                      Field{"payload", &QuadrupedScenario::payload},
                      Field{"sweep", &QuadrupedScenario::sweep},
                      Field{"compare", &QuadrupedScenario::compare},
                      Field{"fall", &QuadrupedScenario::fall},
                      Field{"limit_speed", &QuadrupedScenario::limit_speed},
                      Field{"integrator", &QuadrupedScenario::integrator},
                      Field{"log_rate_hz", &QuadrupedScenario::log_rate_hz},
                      Field{"report", &QuadrupedScenario::report}};
  }
  void Validate() const;  ///< throws ParameterError
};

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
