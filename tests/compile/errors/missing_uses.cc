// says: Uses(...) is missing before the function
#include <tenon/systems/block.h>

class Twice final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<double> u{this, {"u"}};
  tenon::OutputPort<double> y{this, {"y"}, [](double u) { return 2 * u; }};
};
