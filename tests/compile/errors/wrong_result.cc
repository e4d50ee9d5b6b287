// says: The function must return exactly the type
#include <tenon/systems/block.h>

class Twice final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<tenon::Vec<3>> u{this, {"u"}};
  tenon::OutputPort<tenon::Vec<3>> y{
      this, {"y"}, tenon::Uses(u), [](const tenon::Vec<3>& u) { return 2 * u; }};
};
