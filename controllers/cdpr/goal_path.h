#pragma once

#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/systems/block.h>

namespace tenon {

/// A goal of the platform, and the motion of its reference at departure.
struct PlatformGoal {
  bool on = false;
  double start = 0;     ///< departure time [s]
  double duration = 1;  ///< duration of the motion [s]
  Vec<3> position = Vec<3>::Zero(), velocity = Vec<3>::Zero(),
         acceleration = Vec<3>::Zero();  ///< motion of the reference at departure, in W [m, m/s, m/s^2]
  Vec<3> euler = Vec<3>::Zero(), euler_rate = Vec<3>::Zero();  ///< ZYX angles at departure [rad, rad/s]
  Vec<3> goal = Vec<3>::Zero();                                ///< goal of the CoM, in W [m]

  static FieldList Fields() {
    return {{"on", &PlatformGoal::on},
            {"start", &PlatformGoal::start, "s"},
            {"duration", &PlatformGoal::duration, "s"},
            {"position", &PlatformGoal::position, "m"},
            {"velocity", &PlatformGoal::velocity, "m/s"},
            {"acceleration", &PlatformGoal::acceleration, "m/s^2"},
            {"euler", &PlatformGoal::euler, "rad"},
            {"euler_rate", &PlatformGoal::euler_rate, "rad/s"},
            {"goal", &PlatformGoal::goal, "m"}};
  }
};

struct GoalPathParams {
  std::shared_ptr<const EquilibriumPath> path;  ///< planned path, followed if no goal is set
  double speed = 0.3;                           ///< maximum speed towards a goal [m/s]
  double shortest = 0.5;                        ///< minimum duration of a motion to a goal [s]
  void Validate() const;                        ///< throws ParameterError
};

/// Selects the path that a platform follows: the planned one or, with a goal, a quintic from the motion of
/// the reference at departure to rest at the goal. The attitude is that of the equilibria; if the planned
/// path prescribes one, it stays constant. The path is computed only when the goal changes, within
/// milliseconds.
class GoalPath final : public LeafSystem<GoalPathParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<PlatformGoal> goal{this, {"goal"}, PlatformGoal{}, "goal that replaces the planned path"};
  OutputPort<FollowedPath> path{this, {"path"}, {params.path}, Uses(goal), &GoalPath::CalcPath};

  /// Returns the value of `goal` that leads from `reference` at `time` to `place` [m]. Throws ParameterError
  /// with the reason if there is no such path.
  PlatformGoal GoalAt(const Vec<3>& place, double time, const CdprReference& reference) const;

 private:
  void CalcPath(const PlatformGoal& goal, FollowedPath* path) const;
};

}  // namespace tenon
