#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

namespace tenon {
namespace {

/// A parameter of a block, and its name in a file that gives it in the units of RobotScale. In such a file it
/// is required, because the block's default holds for one robot only.
struct InUnits {
  std::string_view from;
  const char* to;
};

template <std::size_t N>
FieldList Relative(FieldList fields, const std::array<InUnits, N>& names) {
  for (Field& field : fields) {
    const auto found = std::ranges::find(names, std::string_view(field.name), &InUnits::from);
    if (found == names.end()) continue;
    field.name = found->to;
    field.required = true;
  }
  return fields;
}

struct RelativeQp : WholeBodyQpParams {
  static FieldList Fields() {
    return Relative(
        WholeBodyQpParams::Fields(),
        std::array{InUnits{"wrench_weight", "wrench_weight"}, InUnits{"moment_weight", "moment_weight"},
                   InUnits{"yaw_weight", "yaw_weight"}, InUnits{"force_weight", "force_weight"},
                   InUnits{"acceleration_weight", "acceleration_weight"},
                   InUnits{"slack_weight", "slack_weight"}});
  }
};

struct RelativeGains : WholeBodyGains {
  static FieldList Fields() {
    FieldList fields =
        Relative(WholeBodyGains::Fields(),
                 std::array{InUnits{"com_stiffness_N_per_m", "com_stiffness_mg_per_l"},
                            InUnits{"com_damping_N_s_per_m", "com_damping_mg_t_per_l"},
                            InUnits{"com_limit_m", "com_limit_l"},
                            InUnits{"swing_limit_m_per_s2", "swing_limit_g"}, InUnits{"qp", "qp"}});
    fields.back().type = &internal::TypeInfoOf<RelativeQp>;
    return fields;
  }
};

struct RelativeGround : GroundBelief {
  static FieldList Fields() {
    return Relative(GroundBelief::Fields(),
                    std::array{InUnits{"roughness_m", "roughness_l"}, InUnits{"level_walk_m", "level_walk_l"},
                               InUnits{"start_roughness_m", "start_roughness_l"}});
  }
};

/// The file of a profile.
struct RelativeProfile {
  RelativeGains whole_body;
  double sway_limit = 0;
  RelativeGround ground;
  double qp_rate_hz = 0;
  ObserverProfile observer;

  static FieldList Fields() {
    return {Required("whole_body", &RelativeProfile::whole_body),
            Required("sway_limit_rad_per_s2", &RelativeProfile::sway_limit)
                .AtLeast(0)
                .Because("0 keeps the trunk level"),
            Required("ground", &RelativeProfile::ground),
            Required("qp_rate_hz", &RelativeProfile::qp_rate_hz).In(Range().Positive().Also([](double hz) {
              Hz(hz);
            })),
            Required("observer", &RelativeProfile::observer)};
  }
  static std::vector<RenamedKey> Renamed() {
    return {{"whole_body.com_stiffness_N_per_m", "com_stiffness_mg_per_l, its value over m g / l"},
            {"whole_body.com_damping_N_s_per_m", "com_damping_mg_t_per_l, its value over m g t / l"},
            {"whole_body.com_limit_m", "com_limit_l, its value over l"},
            {"whole_body.swing_limit_m_per_s2", "swing_limit_g, its value over g"},
            {"ground.roughness_m", "roughness_l, its value over l"},
            {"ground.level_walk_m", "level_walk_l, its value over l"},
            {"ground.start_roughness_m", "start_roughness_l, its value over l"}};
  }
};

LocomotionProfile For(const RobotScale& scale, const YamlDocument& document) {
  const auto file = document.Read<RelativeProfile>();
  const double m = scale.mass, l = scale.length, g = scale.gravity, t = scale.Time();
  LocomotionProfile profile{.whole_body = file.whole_body,
                            .sway_limit = file.sway_limit,
                            .ground = file.ground,
                            .qp_rate_hz = file.qp_rate_hz,
                            .observer = file.observer};
  WholeBodyGains& gains = profile.whole_body;
  gains.com_stiffness *= m * g / l;
  gains.com_damping *= m * g * t / l;
  gains.com_limit *= l;
  gains.swing_limit *= g;
  // The whole cost is multiplied by (m g)^2, which leaves the weights of forces unchanged.
  gains.qp.moment_weight /= l * l;
  gains.qp.tilt_weight /= l * l;
  gains.qp.yaw_weight /= l * l;
  gains.qp.acceleration_weight *= m * m;
  gains.qp.slack_weight *= m * m;
  GroundBelief& ground = profile.ground;
  ground.roughness *= l;
  ground.level_walk *= l;
  ground.start_roughness *= l;
  return profile;
}

}  // namespace

LocomotionProfile LoadLocomotionProfile(const YamlFile& file, const RobotScale& scale) {
  return For(scale, LoadResource("profiles", file));
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
  params.trunk_planner = {.robot = robot, .sway_limit = profile.sway_limit};
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
