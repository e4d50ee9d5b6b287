#pragma once

// Common code of the examples in this folder: a shipped walk at 0.1 m/s.

#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/simulation.h>
#include <tenon/systems/yaml/resources.h>

#include <cstdio>

inline tenon::QuadrupedWalkParams TrotParams() {
  tenon::QuadrupedWalkParams params =
      tenon::MakeQuadrupedWalk(tenon::LoadQuadruped(tenon::FindResource("robots", "dogbot")));
  params.walk.segments = {{.gait = tenon::Gait::kStand, .duration = 0.5},
                          {.gait = tenon::Gait::kTrot, .forward = 0.1, .duration = 100}};
  return params;
}

/// Runs for `duration` seconds and prints the position of the robot. Returns an exit code: 1 if it fell, else
/// 0.
inline int WalkFor(double duration, tenon::Simulator& simulator, const tenon::QuadrupedWalk& loop) {
  const tenon::RunStatus status = simulator.AdvanceTo(duration);
  const auto& state = simulator.context().Eval(loop.world.state);
  std::printf("t = %.2f s: the trunk is at x = %.3f m, z = %.3f m %s\n", status.time, state.p_WB[0],
              state.p_WB[2], status.reason.c_str());
  return status.ended ? 1 : 0;
}
