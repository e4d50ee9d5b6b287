#pragma once

#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/tests/plants/legged/mujoco_quadruped.h>

namespace tenon::test {

enum class Engine { kTenon, kMujoco };

/// Keys of the apps that run with MuJoCo in the place of the plant.
struct MujocoEngine {
  Engine engine = Engine::kMujoco;
  int steps_per_ms = MujocoQuadrupedParams().steps_per_ms;
  double contact_time = MujocoQuadrupedParams().contact_time;

  static FieldList Fields() {
    return {{"engine", &MujocoEngine::engine},
            {"steps_per_ms", &MujocoEngine::steps_per_ms},
            {"contact_time_s", &MujocoEngine::contact_time}};
  }

  void Replace(DiagramBuilder& builder, const QuadrupedWorld& world) const {
    if (engine == Engine::kMujoco)
      builder.Replace<MujocoQuadruped>(world.plant, MujocoQuadrupedParams{.plant = world.plant.params,
                                                                          .steps_per_ms = steps_per_ms,
                                                                          .contact_time = contact_time});
  }
};

}  // namespace tenon::test
