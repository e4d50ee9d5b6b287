#pragma once

#include <tenon/apps/common/columns.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>

namespace tenon::apps {

/// Columns of a state's pose and velocity in a log.
struct StateColumns {
  std::vector<std::size_t> position, attitude, velocity;

  static StateColumns Of(const std::vector<std::string>& names, const auto&... state) {
    return {Columns(names, state..., &LeggedState::p_WB), Columns(names, state..., &LeggedState::q_WB),
            Columns(names, state..., &LeggedState::v_W)};
  }
};

/// Errors of an estimated state. The tilt error is the angle between the true and the estimated vertical.
class StateErrors {
 public:
  void Add(std::span<const double> row, const StateColumns& estimated, const StateColumns& truth);
  void AddTo(Summary& summary, const std::string& prefix = "") const;
  Tally drift, height_drift;  ///< errors of position and height [m]

 private:
  Tally velocity_, tilt_;  // [m/s], [rad]
  std::optional<double> position_end_;
};

/// Figures of the state estimate and of the walk relative to it (PathErrors), from a log of the true state,
/// the estimate and TrackingError::path. Without an estimator there are no figures. Position and yaw
/// drift, because no sensor measures them.
class EstimateFigures {
 public:
  explicit EstimateFigures(const QuadrupedWalk& loop) : loop_(loop) {}
  void Begin(const std::vector<std::string>& names);
  void Row(std::span<const double> row);
  void AddTo(Summary& summary) const;
  /// Adds the errors without drift, and the drift. Returns false if there is no estimator.
  bool AddPathTo(Summary& summary) const;

 private:
  const QuadrupedWalk& loop_;
  StateColumns true_, estimated_;
  StateErrors errors_;
  std::vector<std::size_t> path_com_, path_foot_;
  Tally path_errors_;  // [m]
  std::array<Tally, kNumLegs> path_foot_errors_;
};

/// Adds figures of the estimate of a force on a foot: its overshoot, relative to the force, and the time
/// after which it stays within 2 % of the force. The force must be the only one of the scenario, constant,
/// and act until the end at `duration` [s]. Other runs have no such figures.
void JudgeFootStep(const QuadrupedScenario& scenario, double duration, const QuadrupedWalk& loop,
                   Outputs& outputs);

}  // namespace tenon::apps
