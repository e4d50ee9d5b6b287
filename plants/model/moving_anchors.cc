#include <tenon/plants/model/moving_anchors.h>
#include <tenon/systems/framework/types/errors.h>

#include <algorithm>
#include <cstddef>
#include <limits>

namespace tenon {

MovingAnchors::MovingAnchors(const CdprDescription& robot) {
  const auto moves = [](const CableDescription& cable) { return cable.anchor_path.has_value(); };
  if (std::ranges::none_of(robot.cables, moves)) return;
  start_ = std::numeric_limits<double>::infinity();
  for (const CableDescription& cable : robot.cables) {
    paths_.emplace_back();
    if (!moves(cable)) continue;
    cable.anchor_path->Validate();
    paths_.back() = Path::Waypoints(cable.anchor_path->offsets, cable.anchor_path->times);
    start_ = std::min(start_, paths_.back()->start_time());
    end_ = std::max(end_, paths_.back()->end_time());
  }
}

CdprDescription MovingAnchors::RobotAt(const CdprDescription& robot, double time) const {
  CdprDescription at = robot;
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    at.cables[i].anchor_W += At(static_cast<int>(i), time).position;
    at.cables[i].anchor_path.reset();
  }
  return at;
}

}  // namespace tenon
