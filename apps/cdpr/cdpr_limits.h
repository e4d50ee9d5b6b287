#pragma once

#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/verdicts.h>
#include <tenon/controllers/cdpr/cable_interference.h>
#include <tenon/controllers/cdpr/cdpr_clearance.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>

namespace tenon::apps {

/// The robot of the plant that stands in the diagram, see CurrentAs.
inline const CdprDescription& RobotOf(const CdprPlant& plant) {
  return CurrentAs<LeafSystem<CdprPlantParams>>(plant).params.robot;
}

/// Checks that a run of a CdprLoop was physically possible, from a log at each tick of its controller:
///
/// The distance between two cables, as straight lines from anchors or pulleys, is at least their diameter.
/// Pairs that touch at the start are assumed to be guided past each other, like the crossed cables of cdpr_8,
/// and are not checked.
///
/// No cable runs through the platform, see CableInterference. If one does at the start, the platform is
/// assumed to be an open frame and is not checked. Cables without tension are not checked.
///
/// The platform's box and the cables with tension touch none of the robot's obstacles.
///
/// The platform's box, payload, hanging load, added bodies and cables, with their sag, stay above the floor,
/// z = 0. The heading differs from its reference by at most a quarter turn: the restoring moment of the
/// cables is proportional to the sine of that angle.
///
/// Slack cables and the largest tension are checked by CdprMonitor. The limits of a plant with other
/// parameters than CdprPlantParams are unknown, and nothing is checked.
class CdprLimits final : public LogSink {
 public:
  /// The signals that must be logged.
  static std::vector<const Source*> Signals(const CdprLoop& loop);

  /// `cable_diameter` is the distance below which two cables touch [m].
  CdprLimits(const CdprLoop& loop, double cable_diameter);
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;
  /// Adds the figures with their limits, and the breaches, to the summary.
  void AddTo(Summary& summary) const;

 private:
  void DistanceRow(std::span<const double> row, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  void PlatformRow(std::span<const double> row, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  void FloorRow(std::span<const double> row, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);

  const CdprLoop& loop_;
  bool known_;  // whether the limits of the plant in the diagram are known
  CdprDescription robot_;
  MovingAnchors anchors_;
  AddedShapes added_;
  double cable_diameter_;
  std::vector<bool> pull_;         // whether each cable has tension
  CdprDescription pulling_;        // robot_ with only those cables that have tension
  MovingAnchors pulling_anchors_;  // the anchors of pulling_
  Eigen::Vector3d box_;            // half edges of the platform's box [m]
  CableInterference interference_;
  CdprClearance clearance_;       // from obstacles, and of cables that do not touch at the start
  CableKinematics all_, cables_;  // kinematics of all cables and of those with tension, at the current row
  bool started_ = false;
  bool open_frame_ = false;
  std::vector<std::size_t> position_, attitude_, euler_, reference_, tension_, payload_, load_;
  std::vector<std::pair<std::size_t, std::size_t>>
      pieces_;  // columns of height and tension of sagging cables
  std::size_t payload_mass_ = 0;

  Tally distances_, angles_, clearances_, heights_, turns_;  // [m], [rad], [m], [m], [rad]
  Breaches breaches_;
};

}  // namespace tenon::apps
