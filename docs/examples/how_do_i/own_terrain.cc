// Lets the robot walk on a custom terrain: a step across the path, and a field of slabs behind it.

#include "../compose/walk.h"

int main() {
  tenon::QuadrupedWalkParams params = TrotParams();
  params.world.plant.terrain = {
      .friction = 0.8,
      .boxes = {{.centre = {0.5, 0}, .size = {0.3, 2}, .height = 0.02, .friction = 0.6}},
      .field = tenon::BoxField{.lower = {0.8, -1}, .upper = {3, 1}, .kinds = {{0.01, 0.8}, {0.02, 0.6}}}};
  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", params);
  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));
  return WalkFor(3, simulator, loop);
}
