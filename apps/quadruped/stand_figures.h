#pragma once

#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/summary.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/systems/simulation/signal_log.h>

namespace tenon::apps {

/// Figures of a standing robot, computed during the run from a log of Signals.
class StandFigures final : public LogSink {
 public:
  /// The signals that must be logged.
  static std::vector<const Source*> Signals(const QuadrupedStand& loop);
  static std::vector<const Source*> Judged(const QuadrupedStand& loop) { return Signals(loop); }
  /// The shapes of a replay.
  static std::vector<const OutputPort<Geometry>*> Shapes(const QuadrupedStand& loop) {
    std::vector<const OutputPort<Geometry>*> shapes{&loop.world.plant.geometry};
    if (const SlidingLoad* load = loop.world.sliding_load) shapes.push_back(&load->geometry);
    return Present(shapes);
  }

  explicit StandFigures(const QuadrupedStand& loop) : world_(loop.world) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;

  void AddTo(Summary& summary) const;

 private:
  const QuadrupedWorld& world_;
  std::vector<std::size_t> position_, attitude_, force_;
  std::vector<double> start_;                 // horizontal position of the trunk [m]
  Tally height_, tilt_;                       // height and tilt of the trunk [m], [rad]
  Tally load_;                                // magnitude of the force on a foot [N]
  std::optional<double> height_end_, drift_;  // [m]
};

}  // namespace tenon::apps
