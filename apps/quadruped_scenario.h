#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <tuple>

#include "tenon/apps/common/outputs.h"
#include "tenon/diagrams/quadruped_stand.h"
#include "tenon/systems/fields.h"
#include "tenon/systems/simulator_options.h"

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

/// When a robot counts as fallen.
struct FallScenario {
  double min_height_ratio = 0.5;  ///< of the trunk above the ground, to that in the nominal stance
  double max_tilt_rad = 1;

  static constexpr auto Fields() {
    return std::tuple{Field{"min_height_ratio", &FallScenario::min_height_ratio},
                      Field{"max_tilt_rad", &FallScenario::max_tilt_rad}};
  }
};

/// One standard deviation each.
struct EncoderScenario {
  double angle_noise_rad = 0;
  double speed_noise_rad_per_s = 0;
  double rate_hz = 1000;

  static constexpr auto Fields() {
    return std::tuple{Field{"angle_noise_rad", &EncoderScenario::angle_noise_rad},
                      Field{"speed_noise_rad_per_s", &EncoderScenario::speed_noise_rad_per_s},
                      Field{"rate_hz", &EncoderScenario::rate_hz}};
  }
};

/// The defaults are those that QuadrupedPlant recommends.
struct LeggedIntegratorScenario {
  int order = 3;
  double rtol = 1e-3;
  double atol_position = 1e-5;  ///< [m, rad]
  double atol_velocity = 1e-3;  ///< [m/s, rad/s]
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
  std::string robot = "dogbot";  ///< a shipped robot or a YAML file
  double duration_s = 10;
  std::uint64_t seed = 1;
  double start_height_m = 0;  ///< of the feet above the plane's origin, at rest in the nominal stance
  TerrainParams terrain;
  JointPdScenario pd;
  EncoderScenario encoders;
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
                      Required("pd", &QuadrupedScenario::pd),
                      Field{"encoders", &QuadrupedScenario::encoders},
                      Field{"fall", &QuadrupedScenario::fall},
                      Field{"limit_speed", &QuadrupedScenario::limit_speed},
                      Field{"integrator", &QuadrupedScenario::integrator},
                      Field{"log_rate_hz", &QuadrupedScenario::log_rate_hz},
                      Field{"report", &QuadrupedScenario::report}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// What the diagram needs to know of a scenario; reads the robot.
QuadrupedStandParams MakeStandParams(const QuadrupedScenario& scenario);
/// For a diagram that holds a QuadrupedStand named "loop".
SimulatorOptions MakeSimulatorOptions(const QuadrupedScenario& scenario);

}  // namespace tenon::apps
