#pragma once

#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/model/path.h>

#include <optional>
#include <vector>

namespace tenon {

/// The anchors of a cable robot that move during a run, on cranes or gantries, see AnchorPath.
///
/// Only the difference between the places of an anchor and of the platform decides the course of a cable. An
/// anchor that has moved by d therefore acts like one that stands while the platform has moved by -d, but
/// the ends of its cable in the world move by d.
class MovingAnchors {
 public:
  MovingAnchors() = default;  ///< all anchors stand
  /// @throws ParameterError if the path of an anchor is not valid.
  explicit MovingAnchors(const CdprDescription& robot);

  bool any() const { return !paths_.empty(); }  ///< whether an anchor of the robot moves
  double start_time() const { return start_; }  ///< time at which the first anchor begins to move [s]
  double end_time() const { return end_; }      ///< time from which on all anchors stand [s]

  /// Displacement of an anchor from its `anchor_W`, with its derivatives. Does not allocate.
  PathPoint At(int cable, double time) const {
    const auto index = static_cast<std::size_t>(cable);
    return any() && paths_[index] ? paths_[index]->At(time) : PathPoint{};
  }

  /// Returns `robot` with its anchors at their places at this time, where they stand.
  CdprDescription RobotAt(const CdprDescription& robot, double time) const;

 private:
  std::vector<std::optional<Path>> paths_;  // one per cable; empty if all anchors stand
  double start_ = 0, end_ = 0;
};

}  // namespace tenon
