#pragma once

#include <tenon/apps/common/breaches.h>
#include <tenon/apps/common/summary.h>
#include <tenon/apps/common/tally.h>
#include <tenon/plants/legged/quadruped_clearance.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/systems/simulation/signal_log.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace tenon::apps {

/// Whether drives, feet, legs, trunk and ground could have done what they did in a run, gathered from a log
/// of every control tick.
///
/// A drive gives no more than its torque-speed line has at the joint's speed, whether or not the plant held
/// it to that. That something else drives the joint faster than the limit is no breach, as long as the drive
/// stays within its line. Links and trunk are no deeper in one another or in the ground than `kPressedIn`,
/// and no foot is pressed in farther than by `kPressedRatio` of its radius, or kPressedIn if that is more.
class LimitFigures final : public LogSink {
 public:
  static constexpr double kPressedIn = 0.005;  // m
  static constexpr double kPressedRatio = 0.5;

  /// What has to be logged for it.
  static std::vector<const Source*> Signals(const QuadrupedPlant& plant);

  explicit LimitFigures(const QuadrupedPlant& plant);
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;
  /// Writes them down, with their limits, and what is beyond them.
  void AddTo(Summary& summary) const;

 private:
  void DriveRow(std::span<const double> row);
  void FootRow(std::span<const double> row);
  void ClearanceRow(std::span<const double> row);

  std::string path_;  // of the plant
  QuadrupedDescription robot_;
  QuadrupedClearance clearance_;
  double foot_limit_;  // [m]
  std::vector<std::size_t> position_, attitude_, q_, qd_, torque_, depth_;

  Tally torques_, speeds_, excesses_, depths_;  // [N m], [rad/s], [N m], [m]
  Tally legs_, trunk_, ground_;                 // [m]
  Breaches breaches_;
};

}  // namespace tenon::apps
