#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon {

FieldList LocomotionProfile::Fields() {
  return {
      Required("whole_body", &LocomotionProfile::whole_body),
      Required("sway_limit_rad_per_s2", &LocomotionProfile::sway_limit)
          .AtLeast(0)
          .Because("0 keeps the trunk level"),
      Field("capture_speed_m_per_s", &LocomotionProfile::capture_speed)
          .AtLeast(0)
          .OrInfinite()
          .Scaled("capture_speed_l_per_t", [](double v, const Scale& s) { return v * s.length / s.Time(); }),
      {"step_timing", &LocomotionProfile::step_timing},
      Required("ground", &LocomotionProfile::ground),
      Required("qp_rate_hz", &LocomotionProfile::qp_rate_hz).In(Range().Positive().Also([](double hz) {
        Hz(hz);
      })),
      Required("observer", &LocomotionProfile::observer)};
}

std::vector<RenamedKey> LocomotionProfile::Renamed() {
  return {{"whole_body.com_stiffness_N_per_m", "com_stiffness_mg_per_l, its value over m g / l"},
          {"whole_body.com_damping_N_s_per_m", "com_damping_mg_t_per_l, its value over m g t / l"},
          {"whole_body.com_limit_m", "com_limit_l, its value over l"},
          {"whole_body.swing_limit_m_per_s2", "swing_limit_g, its value over g"},
          {"ground.roughness_m", "roughness_l, its value over l"},
          {"ground.level_walk_m", "level_walk_l, its value over l"},
          {"ground.start_roughness_m", "start_roughness_l, its value over l"}};
}

LocomotionProfile LoadLocomotionProfile(const YamlFile& file, const RobotScale& scale) {
  return LoadResource("profiles", file).Read<LocomotionProfile>(&scale);
}

FootSchedulerParams LoadGaits(const YamlFile& file, const RobotScale& scale) {
  return LoadResource("gaits", file).Read<GaitFile>().For(scale.Weight());
}

LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot, const LocomotionProfile& profile,
                                      const FootSchedulerParams& gaits) {
  LeggedLocomotionParams params;
  params.scheduler = gaits;
  params.ground = {.robot = robot, .belief = profile.ground};
  params.com_planner.robot = robot;
  params.swing_planner.robot = robot;
  params.swing_planner.capture_speed = profile.capture_speed;
  params.trunk_planner = {.robot = robot, .sway_limit = profile.sway_limit};
  params.step_timing.timing = profile.step_timing;
  params.whole_body.robot = robot;
  params.whole_body.gains = profile.whole_body;
  params.whole_body.qp_rate = Hz(profile.qp_rate_hz);
  return params;
}

LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot) {
  const RobotScale scale = ScaleOf(robot);
  return MakeLocomotion(robot, LoadLocomotionProfile({"standard"}, scale), LoadGaits({"standard"}, scale));
}

DisturbanceObserverParams MakeObserver(const QuadrupedDescription& robot, const LocomotionProfile& profile) {
  const ObserverProfile& gains = profile.observer;
  DisturbanceObserverParams params;
  params.kind = gains.kind;
  params.legs = {robot, gains.legs};
  params.com = {robot, gains.com};
  params.focchi = gains.focchi;
  params.ndo.robot = robot;
  params.ndo.gain = gains.ndo_gain;
  params.ndo.min_singular_value = gains.legs.min_singular_value;
  return params;
}

}  // namespace tenon
