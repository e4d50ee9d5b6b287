// Lets a robot of four legs and three ropes climb a slope. Robot and ropes are files.

#include <tenon/systems/yaml/yaml.h>

#include "../compose/walk.h"

#include <vector>

struct Climb {
  tenon::TerrainParams terrain;
  std::vector<tenon::Rope> ropes;
  static tenon::FieldList Fields() { return {{"terrain", &Climb::terrain}, {"ropes", &Climb::ropes}}; }
};

int main() {
  const Climb climb = tenon::YamlDocument::Load(CLIMB).Read<Climb>();
  auto params = tenon::MakeQuadrupedWalk(tenon::LoadQuadruped(tenon::FindResource("robots", "go2")));
  params.walk.segments = {{.gait = tenon::Gait::kTrot, .forward = 0.1, .duration = 100}};
  params.world.plant.terrain = climb.terrain;
  params.locomotion.whole_body.gains.qp.friction = 0.35;
  params.locomotion.whole_body.gains.qp.friction_pyramid = tenon::FrictionPyramid::kInscribed;
  tenon::AddRopes(climb.ropes, &params);

  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", params);
  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));
  return WalkFor(3, simulator, loop);
}
