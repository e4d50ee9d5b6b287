#include <tenon/apps/quadruped/legged_scenario.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {

void LiveScenario::Validate() const {
  const auto range = [](const char* key, const Vec<2>& limits) {
    Demand(limits.allFinite() && limits[0] <= 0 && limits[1] >= 0,
           fmt::format("{} = [{}, {}] must contain 0: give the least value, then the largest one", key,
                       limits[0], limits[1]));
  };
  range("forward_m_per_s", forward_m_per_s);
  range("sideways_m_per_s", sideways_m_per_s);
  range("yaw_rad_per_s", yaw_rad_per_s);
}

FieldList LeggedScenario::Fields() {
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

PathVerdict MakePathVerdict(const WalkScenario& walk, bool live) {
  if (live) return {};
  const WalkSchedule::Extent extent = WalkSchedule(walk.path).extent();
  if (extent.length == 0 && extent.turn == 0) return {};
  return {walk.path_tolerance, extent.length};
}

double EndOfWalk(const WalkScenario& walk) {
  return Blame("walk.path", [&] { return WalkSchedule(walk.path).end_time(); });
}

SimulatorOptions MakeSimulatorOptions(const LeggedScenario& scenario, const QuadrupedPlant& plant) {
  if (!LoadPlace(scenario.robot).empty())
    throw KeyError("robot.link",
                   "only a run of tenon-quadruped drives a robot: remove this key to simulate it");
  SimulatorOptions options = scenario.integrator.Options(plant);
  options.seed = scenario.seed;
  return options;
}

std::string Describe(const LeggedScenario& scenario, double duration) {
  return fmt::format("{}, {:.4g} s, seed {}", ResourceName(scenario.robot), duration, scenario.seed);
}

}  // namespace tenon::apps
