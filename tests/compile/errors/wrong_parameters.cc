// says: Add: the block's constructor does not take these arguments
#include <tenon/systems/simulation.h>

struct PdParams {
  double kp = 1;
};
struct CartParams {
  double mass = 1;
};
class Pd final : public tenon::LeafSystem<PdParams> {
 public:
  using LeafSystem::LeafSystem;
};

int main() {
  tenon::DiagramBuilder builder;
  builder.Add<Pd>("pd", CartParams{});
}
