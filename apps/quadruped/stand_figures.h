#pragma once

#include <tenon/apps/common/summary.h>
#include <tenon/apps/common/tally.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/systems/simulation/signal_log.h>

#include <optional>
#include <vector>

namespace tenon::apps {

/// The figures of a standing robot, gathered while it runs.
class StandFigures final : public LogSink {
 public:
  /// What it wants to see, in a diagram that calls the QuadrupedStand "loop".
  static std::vector<const Source*> Signals(const QuadrupedStand& loop);
  static std::vector<const Source*> Judged(const QuadrupedStand& loop) { return Signals(loop); }
  /// What shows it in a replay.
  static std::vector<const OutputPort<Geometry>*> Shapes(const QuadrupedStand& loop) {
    std::vector<const OutputPort<Geometry>*> shapes{&loop.world.plant.geometry};
    if (const SlidingLoad* load = loop.world.sliding_load) shapes.push_back(&load->geometry);
    return shapes;
  }

  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;

  /// Writes them down.
  void AddTo(Summary& summary) const;

 private:
  std::vector<std::size_t> position_, attitude_, force_;
  std::vector<double> start_;                 // horizontal [m]
  Tally height_, tilt_, load_;                // of the trunk [m], [rad]; in magnitude [N]
  std::optional<double> height_end_, drift_;  // [m]
};

}  // namespace tenon::apps
