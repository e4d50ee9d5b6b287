// says first: speed
#include <tenon/systems/block.h>

class Twice final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<double> speed{this, {"speed"}};
  tenon::OutputPort<double> y{this, {"y"}, tenon::Uses(sped), [](double u) { return 2 * u; }};
};
