#pragma once

#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/summary.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/diagrams/legged/quadruped_walk.h>

namespace tenon::apps {

/// Figures of the state estimate and of the walk relative to it (PathErrors), from a log of the true state,
/// the estimate and TrackingError::path. Without an estimator there are no figures. The tilt error is the
/// angle between the true and the estimated vertical. Position and yaw drift, because no sensor measures
/// them.
class EstimateFigures {
 public:
  explicit EstimateFigures(const QuadrupedWalk& loop) : loop_(loop) {}
  void Begin(const std::vector<std::string>& names);
  void Row(std::span<const double> row);
  void AddTo(Summary& summary) const;
  /// Adds the errors without drift, and the drift. Returns false if there is no estimator.
  bool AddPathTo(Summary& summary) const;

 private:
  /// Columns of a state in the log.
  struct State {
    std::vector<std::size_t> position, attitude, velocity;
  };
  const QuadrupedWalk& loop_;
  State true_, estimated_;
  Tally velocity_, tilt_;  // errors [m/s], [rad]
  std::optional<double> position_end_;
  std::vector<std::size_t> path_com_, path_foot_;
  Tally path_errors_, drift_, height_drift_;  // [m]
  std::array<Tally, kNumLegs> path_foot_errors_;
};

/// Adds figures of the estimate of a force on a foot: its overshoot, relative to the force, and the time
/// after which it stays within 2 % of the force. The force must be the only one of the scenario, constant,
/// and act until the end at `duration` [s]. Other runs have no such figures.
void JudgeFootStep(const QuadrupedScenario& scenario, double duration, const QuadrupedWalk& loop,
                   Outputs& outputs);

}  // namespace tenon::apps
