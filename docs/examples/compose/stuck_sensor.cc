// Freezes the output of the walking robot's inertial unit at t = 2 s. The observer then reads the last value.

#include <tenon/systems/block.h>

#include "walk.h"

/// y = u until `time`, then the value of u at `time`.
struct StickParams {
  double time = 0;  // s
  tenon::Rate rate = tenon::Hz(1000);
};
template <class T>
class Stick final : public tenon::LeafSystem<StickParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<T> u{this, {"u"}};
  tenon::Scratch<T> last{this, "last"};
  tenon::OutputPort<T> y{
      this,
      {"y"},
      tenon::Sampled{params.rate},
      tenon::Uses(time, u, last),
      [this](double t, const T& u, T& last) -> T { return t < params.time ? last = u : last; }};
};

int main() {
  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", TrotParams());
  auto& stick = builder.Add<Stick<tenon::ImuMeasurement>>("stick", {.time = 2});
  builder.Insert(loop.world.inertial, stick.u, stick.y);

  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));
  return WalkFor(3, simulator, loop);
}
