// says: The offset of Sampled is a number of seconds
#include <tenon/systems/block.h>

class Twice final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<double> u{this, {"u"}};
  tenon::OutputPort<double> y{
      this, {"y"}, 0.0, tenon::Sampled{tenon::Hz(100), tenon::Milliseconds(3)}, tenon::Uses(u), [](double u) {
        return 2 * u;
      }};
};
