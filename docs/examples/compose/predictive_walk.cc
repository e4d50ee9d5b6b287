// Pushes Go2 at 1 m/s, with the shipped planners and with predictive control in the place of the trunk
// planner.

#include <tenon/controllers/legged/planning/centroidal_mpc.h>

#include "walk.h"

namespace {

/// Go2 at 1 m/s, with 100 N to the left for 0.1 s after 3.8 s.
tenon::QuadrupedWalkParams PushedParams() {
  tenon::QuadrupedWalkParams params =
      tenon::MakeQuadrupedWalk(tenon::LoadQuadruped(tenon::FindResource("robots", "go2")));
  params.locomotion.pace = tenon::PaceProperties();
  params.walk.segments = {{.gait = tenon::Gait::kStand, .duration = 0.5},
                          {.gait = tenon::Gait::kTrot, .forward = 1, .duration = 100}};
  params.world.pulses = {{.push = {.force_W = {0, 100, 0}}, .start = 3.8, .duration = 0.1}};
  return params;
}

void UsePredictiveControl(tenon::DiagramBuilder& builder, tenon::QuadrupedWalk& loop) {
  tenon::LeggedLocomotion& walk = loop.locomotion;
  auto& mpc =
      builder.Replace<tenon::CentroidalMpc>(*walk.trunk_planner, {.robot = walk.whole_body.params.robot});
  builder.Connect(walk.com_planner.path, mpc.path);
  builder.Connect(walk.ground_estimator.ground, mpc.ground);
  builder.Connect(mpc.footholds, walk.swing_planner.planned);
}

}  // namespace

int main() {
  for (const bool predictive : {false, true}) {
    std::printf("%s: ", predictive ? "predictive control" : "shipped planners");
    tenon::DiagramBuilder builder;
    auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", PushedParams());
    if (predictive) UsePredictiveControl(builder, loop);
    tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));
    WalkFor(6, simulator, loop);
  }
}
