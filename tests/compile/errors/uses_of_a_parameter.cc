// says: Uses(...) takes ports, states, shared values
#include <tenon/systems/block.h>

struct GainParams {
  double k = 1;
};
class Gain final : public tenon::LeafSystem<GainParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<double> u{this, {"u"}};
  tenon::OutputPort<double> y{this, {"y"}, tenon::Uses(params.k), [](double k) { return k; }};
};
