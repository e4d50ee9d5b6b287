#pragma once

#include <tenon/apps/common/summary.h>
#include <tenon/apps/common/tally.h>
#include <tenon/plants/model/quadruped_description.h>

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tenon::apps {

/// How well the trunk's state is estimated, and how well the robot walks where it believes to be
/// (PathErrors), from a log of "loop.world.plant.state", "loop.estimator.estimate" and "loop.errors.path";
/// nothing, if there is no estimator. The tilt is the angle between the true and the estimated vertical;
/// position and yaw, which no sensor sees, drift.
class EstimateFigures {
 public:
  void Begin(const std::vector<std::string>& names);
  void Row(std::span<const double> row);
  void AddTo(Summary& summary) const;
  /// The errors over ground without drift, and the drift; returns whether there is an estimator.
  bool AddPathTo(Summary& summary) const;

 private:
  /// Columns of the two states.
  struct State {
    std::vector<std::size_t> position, attitude, velocity;
  };
  State true_, estimated_;
  Tally velocity_, tilt_;  // errors [m/s], [rad]
  std::optional<double> position_end_;
  std::vector<std::size_t> path_com_, path_foot_;
  Tally path_errors_, drift_, height_drift_;  // [m]
  std::array<Tally, kNumLegs> path_foot_errors_;
};

}  // namespace tenon::apps
