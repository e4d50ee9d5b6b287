// Replaces the swing planner of the shipped walking robot.

#include "arc_planner.h"
#include "walk.h"

int main() {
  const tenon::QuadrupedWalkParams params = TrotParams();
  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", params);
  auto& planner =
      builder.Replace<ArcPlanner>(loop.locomotion.swing_planner, {.robot = params.world.plant.robot});

  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));
  const int code = WalkFor(3, simulator, loop);
  std::printf("'%s' lifts feet by %.0f mm\n", planner.name().c_str(), 1000 * planner.params.height);
  return code;
}
