// says: A rate has a unit: Hz(100)
#include <tenon/systems/block.h>

class Twice final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<double> u{this, {"u"}};
  tenon::OutputPort<double> y{
      this, {"y"}, tenon::Sampled{100}, tenon::Uses(u), [](double u) { return 2 * u; }};
};
