#pragma once

#include <vector>

#include <tenon/apps/common/outputs.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/systems/simulation/signal_log.h>

namespace tenon::apps {

/// The figures of a standing robot, gathered while it runs.
class StandFigures final : public LogSink {
 public:
  /// What it wants to see, in a diagram that calls the QuadrupedStand "loop".
  static std::vector<const Source*> Signals(const QuadrupedStand& loop);
  static std::vector<const Source*> Judged(const QuadrupedStand& loop) { return Signals(loop); }
  /// What shows it in a replay.
  static std::vector<const OutputPort<Geometry>*> Shapes(const QuadrupedStand& loop) {
    return {&loop.world.plant.geometry};
  }

  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;

  /// Writes them down.
  void AddTo(Summary& summary) const;

  double height_min() const { return height_min_; }     ///< of the trunk, p_WB's z [m]
  double height_end() const { return height_end_; }     ///< [m]
  double drift() const { return drift_; }               ///< horizontal, from where it began to the end [m]
  double tilt_max() const { return tilt_max_; }         ///< [rad]
  double torque_max() const { return torque_max_; }     ///< of the drives, in magnitude [N m]
  double foot_force_max() const { return force_max_; }  ///< in magnitude [N]

 private:
  std::vector<std::size_t> position_, attitude_, torque_, force_;
  std::vector<double> start_;
  double height_min_ = 0, height_end_ = 0, drift_ = 0, tilt_max_ = 0, torque_max_ = 0, force_max_ = 0;
};

}  // namespace tenon::apps
