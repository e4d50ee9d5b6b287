#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/tally.h>

namespace tenon::apps {

/// How well the trunk's state is estimated, from a log of "loop.world.plant.state" and
/// "loop.estimator.estimate"; nothing, if there is no estimator. The tilt is the angle between the true and
/// the estimated vertical; position and yaw, which no sensor sees, drift.
class EstimateFigures {
 public:
  void Begin(const std::vector<std::string>& names);
  void Row(std::span<const double> row);
  void AddTo(Summary& summary) const;

 private:
  /// Columns of the two states.
  struct State {
    std::vector<std::size_t> position, attitude, velocity;
  };
  State true_, estimated_;
  Tally velocity_, tilt_;  // errors [m/s], [rad]
  std::optional<double> position_end_;
};

}  // namespace tenon::apps
