// A custom primitive for vectors of any size, and its unit test.

#include <tenon/systems/block.h>
#include <tenon/systems/simulation.h>

#include <cstdio>
#include <string>

struct DeadZoneParams {
  double width = 0;       // [unit]
  std::string unit = "";  // unit of input and output
  void Validate() const { tenon::Demand(width >= 0, "width must not be negative"); }
};

/// A dead zone in each element: y = 0 for |u| <= width, else u - sign(u) width.
template <int N>
class DeadZone final : public tenon::LeafSystem<DeadZoneParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::Vec<N>> u{this, {"u", params.unit}};
  tenon::Parameter<double> width{this, {"width", params.unit}, params.width};  // can be changed in a run
  tenon::OutputPort<tenon::Vec<N>> y{
      this, {"y", params.unit}, tenon::Uses(u, width), [](const tenon::Vec<N>& u, double width) {
        return tenon::Vec<N>(u - u.cwiseMax(-width).cwiseMin(width));
      }};
};

int main() {
  tenon::DiagramBuilder builder;
  auto& zone = builder.Add<DeadZone<2>>("zone", {.width = 0.1, .unit = "m"});
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(zone.u, {0.05, -0.3});
  const tenon::Vec<2> y = context->Eval(zone.y);
  std::printf("(0.05, -0.3) m becomes (%g, %g) m\n", y[0], y[1]);
  return y.isApprox(tenon::Vec<2>(0, -0.2)) ? 0 : 1;
}
