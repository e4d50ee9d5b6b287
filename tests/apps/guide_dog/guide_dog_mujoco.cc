// tenon-guide-dog on two engines: `guide-dog-mujoco C1 --set custom.engine=mujoco`

#include <tenon/apps/guide_dog/guide_dog_app.h>
#include <tenon/tests/apps/mujoco_engine.h>

int main(int argc, char** argv) {
  using namespace tenon;
  return apps::GuideDogApp()
      .Customise<test::MujocoEngine>(
          [](DiagramBuilder& builder, GuideDog& dog, const test::MujocoEngine& engine) {
            engine.Replace(builder, dog.world);
          })
      .Run(argc, argv);
}
