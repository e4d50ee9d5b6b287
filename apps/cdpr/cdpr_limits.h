#pragma once

#include <tenon/apps/common/breaches.h>
#include <tenon/apps/common/summary.h>
#include <tenon/apps/common/tally.h>
#include <tenon/controllers/cdpr/cable_interference.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/systems/simulation/signal_log.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace tenon::apps {

/// Whether cables, platform and floor could have done what they did in a run of a CdprLoop, gathered from a
/// log of every tick of its controller:
///  - two cables are no nearer than their diameter, as straight lines from anchors or pulleys. Those that
///    touch at the start are taken to be led past each other, as the crossed cables of cdpr_8 have to be: of
///    them nothing is known;
///  - no cable runs through the platform, see CableInterference. Where one does at the start, it is an open
///    frame, of which nothing is known either. Cables without tension, slack or broken, are not judged;
///  - platform, payload, hanging load and cables, as they sag, stay above the floor, z = 0;
///  - the platform is turned about the vertical by no more than a quarter turn from its reference: the moment
///    with which the cables turn it back grows as the sine of that angle.
///
/// What the winches hold, and slack, is CdprMonitor's.
class CdprLimits final : public LogSink {
 public:
  /// What has to be logged for it.
  static std::vector<const Source*> Signals(const CdprLoop& loop);

  /// Cables nearer than `cable_diameter` [m] touch.
  CdprLimits(const CdprLoop& loop, double cable_diameter);
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;
  /// Writes them down, with their limits, and what is beyond them.
  void AddTo(Summary& summary) const;

 private:
  double Distance(std::size_t a, std::size_t b, const Eigen::Vector3d& p_WB) const;
  void CableRow(std::span<const double> row, const Eigen::Vector3d& p_WB);
  void PlatformRow(std::span<const double> row, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  void FloorRow(std::span<const double> row, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);

  CdprDescription robot_;
  double cable_diameter_;
  std::vector<bool> pull_;   // by cable
  CdprDescription pulling_;  // the robot with these cables alone
  CableInterference interference_;
  CableKinematics all_, cables_;  // of the row: of all, and of those
  bool started_ = false;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;  // of cables that may not touch
  bool open_frame_ = false;
  std::vector<std::size_t> position_, attitude_, euler_, reference_, tension_, payload_, load_;
  std::vector<std::pair<std::size_t, std::size_t>> pieces_;  // of cables that sag: height, tension
  std::size_t payload_mass_ = 0;

  Tally distances_, angles_, heights_, turns_;  // [m], [rad], [m], [rad]
  Breaches breaches_;
};

}  // namespace tenon::apps
