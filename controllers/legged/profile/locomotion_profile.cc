#include <tenon/controllers/legged/profile/locomotion_profile.h>

#include <tenon/plants/model/resources.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon {

LocomotionProfile LoadLocomotionProfile(const std::string& name) {
  return YamlDocument::Load(FindResource("profiles", name)).Read<LocomotionProfile>();
}

LocomotionProfile LoadLocomotionProfile(const YamlText& what) {
  return LoadResource("profiles", what).Read<LocomotionProfile>();
}

LeggedLocomotionParams MakeLocomotion(const QuadrupedDescription& robot, const LocomotionProfile& profile,
                                      const std::string& gaits) {
  LeggedLocomotionParams params;
  params.scheduler = YamlDocument::Load(FindResource("gaits", gaits)).Read<FootSchedulerParams>();
  params.ground = {.robot = robot, .belief = profile.ground};
  params.com_planner.robot = robot;
  params.swing_planner.robot = robot;
  params.trunk_planner = {.robot = robot, .sway_limit = profile.sway_limit};
  params.whole_body.robot = robot;
  params.whole_body.gains = profile.whole_body;
  params.whole_body.qp_rate = Hz(profile.qp_rate_hz);
  return params;
}

DisturbanceObserverParams MakeObserver(const QuadrupedDescription& robot, const LocomotionProfile& profile) {
  const ObserverProfile& tuning = profile.observer;
  DisturbanceObserverParams params;
  params.kind = tuning.kind;
  params.legs = {robot, tuning.legs};
  params.com = {robot, tuning.com};
  params.ndo.robot = robot;
  params.ndo.gain = tuning.ndo_gain;
  return params;
}

}  // namespace tenon
