// tenon-quadruped on two engines: `quadruped-mujoco A1 --set custom.engine=mujoco`

#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/tests/apps/mujoco_engine.h>

int main(int argc, char** argv) {
  using namespace tenon;
  return apps::QuadrupedApp()
      .Customise<test::MujocoEngine>(
          [](DiagramBuilder& builder, QuadrupedWalk& walk, const test::MujocoEngine& engine) {
            engine.Replace(builder, walk.world);
          })
      .Run(argc, argv);
}
