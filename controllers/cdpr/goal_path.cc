#include <tenon/controllers/cdpr/goal_path.h>
#include <tenon/plants/signals/euler.h>

#include <fmt/core.h>

namespace tenon {
namespace {

std::shared_ptr<const EquilibriumPath> PathTo(const PlatformGoal& goal, const EquilibriumPath& planned) {
  const double end = goal.start + goal.duration;
  const auto move = [&](const PathPoint& from, const Vec<3>& to) {
    return Path::Move(from, goal.start, to, end);
  };
  StaticsOptions options = planned.options();
  std::optional<Path> attitude;
  if (options.attitude) {
    attitude = move({goal.euler, goal.euler_rate, Vec<3>::Zero()}, goal.euler);
  } else {
    StaticEquilibrium& near = options.warm_start.emplace();
    near.p_WB = goal.position;
    near.euler = goal.euler;
    near.R_WB = RotationFromEuler(goal.euler);
    near.tension = planned.At(planned.path().start_time()).tension;
  }
  return std::make_shared<EquilibriumPath>(
      planned.robot(), move({goal.position, goal.velocity, goal.acceleration}, goal.goal), options, attitude);
}

}  // namespace

void GoalPathParams::Validate() const {
  Demand(path != nullptr, "no path given: make an EquilibriumPath and share it");
  Demand(std::isfinite(speed) && speed > 0, fmt::format("speed is {} m/s and must be positive", speed));
  Demand(std::isfinite(shortest) && shortest > 0,
         fmt::format("shortest is {} s and must be positive", shortest));
}

void GoalPath::CalcPath(const PlatformGoal& goal, FollowedPath* path) const {
  path->path = goal.on ? PathTo(goal, *params.path) : params.path;
}

PlatformGoal GoalPath::GoalAt(const Vec<3>& place, double time, const CdprReference& reference) const {
  constexpr double kPeak = 15.0 / 8;  // peak over mean speed of a quintic from rest to rest
  PlatformGoal goal{.on = true,
                    .start = time,
                    .position = reference.position,
                    .velocity = reference.velocity,
                    .acceleration = reference.acceleration,
                    .euler = reference.euler,
                    .euler_rate = reference.euler_rate,
                    .goal = place};
  goal.duration = std::max(params.shortest, kPeak * (place - reference.position).norm() / params.speed);
  PathTo(goal, *params.path);
  return goal;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::PlatformGoal);
