// says: write `using LeafSystem::LeafSystem;` in it
#include <tenon/systems/simulation.h>

struct PdParams {
  double kp = 1;
};
class Pd final : public tenon::LeafSystem<PdParams> {
 public:
  tenon::InputPort<double> u{this, {"u"}};
};

int main() {
  tenon::DiagramBuilder builder;
  builder.Add<Pd>("pd", PdParams{.kp = 3});
}
