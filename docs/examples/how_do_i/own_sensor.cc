// Adds a custom sensor to the walking robot: a range finder below the trunk, at 20 Hz, with noise and a delay
// of 50 ms.

#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/primitives/sample_delay.h>

#include "../compose/walk.h"

struct RangeFinderParams {
  tenon::Rate rate = tenon::Hz(20);
  double deviation = 0.003;  // standard deviation of the noise [m]
};
class RangeFinder final : public tenon::LeafSystem<RangeFinderParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::LeggedState> state{this, {"state"}};
  tenon::Random noise{this, "noise"};
  tenon::OutputPort<double> range{
      this, {"range", "m"}, tenon::Sampled{params.rate}, tenon::Uses(state, noise), &RangeFinder::CalcRange};

 private:
  /// Distance along the trunk's z axis to level ground at z = 0.
  double CalcRange(const tenon::LeggedState& x, tenon::RandomStream& noise) const {
    return x.p_WB[2] / x.R_WB()(2, 2) + params.deviation * noise.Normal();
  }
};

int main() {
  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", TrotParams());
  auto& finder = builder.Add<RangeFinder>("finder");
  auto& late = builder.Add<tenon::SampleDelay<double>>(
      "late", {.samples = 1, .initial = 0.4, .rate = finder.params.rate, .unit = "m"});
  builder.Connect(loop.world.state, finder.state);
  builder.Connect(finder.range, late.u);

  tenon::Simulator simulator(builder.Build());
  const auto log = simulator.AddLog(tenon::Hz(20), {&late.y});
  const int code = WalkFor(1, simulator, loop);
  std::printf("%zu ranges, the last one is %.3f m\n", log->rows(), simulator.context().Eval(late.y));
  return code;
}
