// says: A calculation must be const
#include <tenon/systems/block.h>

class Counter final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<double> u{this, {"u"}};
  tenon::OutputPort<double> y{this, {"y"}, tenon::Uses(u), &Counter::CalcY};

 private:
  double CalcY(double u) { return u + ++count_; }
  int count_ = 0;
};
