// says: a lambda not `mutable`
#include <tenon/systems/block.h>

class Count final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<double> u{this, {"u"}};
  tenon::OutputPort<double> y{this, {"y"}, tenon::Uses(u), [n = 0](double u) mutable { return u + ++n; }};
};
