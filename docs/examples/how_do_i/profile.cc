// Prints the time that each block of a run takes.

#include "../compose/walk.h"

int main() {
  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", TrotParams());
  tenon::SimulatorOptions options = tenon::RecommendedOptions(loop);
  options.profile = true;
  tenon::Simulator simulator(builder.Build(), options);
  const int code = WalkFor(0.5, simulator, loop);
  std::printf("%s", simulator.Profile().Text().c_str());
  return code;
}
