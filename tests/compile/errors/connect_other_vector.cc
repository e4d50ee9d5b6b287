// says: Connect: the two ports have different types
#include <tenon/systems/simulation.h>

class Source final : public tenon::LeafSystem<void> {
 public:
  tenon::OutputPort<Eigen::Vector4d> q{
      this, {"q"}, tenon::Uses(), [] { return Eigen::Vector4d(1, 0, 0, 0); }};
};
class Sink final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<tenon::Vec<4>> q{this, {"q"}};
};

int main() {
  tenon::DiagramBuilder builder;
  auto& source = builder.Add<Source>("source");
  auto& sink = builder.Add<Sink>("sink");
  builder.Connect(source.q, sink.q);
}
