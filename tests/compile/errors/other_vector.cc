// says: The function's parameters must be exactly the values of Uses(...)
#include <tenon/systems/block.h>

class Norm final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<tenon::Vec<4>> q{this, {"q"}};
  tenon::OutputPort<double> norm{this, {"norm"}, tenon::Uses(q), &Norm::CalcNorm};

 private:
  double CalcNorm(const Eigen::Vector4d& q) const { return q.norm(); }
};
