// tenon-quadruped on two engines: `quadruped-mujoco A1 --set custom.engine=mujoco`

#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/tests/plants/legged/mujoco_quadruped.h>

namespace tenon::test {
namespace {

enum class Engine { kTenon, kMujoco };
constexpr auto EnumNames(Engine) {
  return std::array{Named{Engine::kTenon, "tenon"}, Named{Engine::kMujoco, "mujoco"}};
}

struct Keys {
  Engine engine = Engine::kMujoco;
  int steps_per_ms = MujocoQuadrupedParams().steps_per_ms;
  double contact_time = MujocoQuadrupedParams().contact_time;
  static FieldList Fields() {
    return {{"engine", &Keys::engine},
            {"steps_per_ms", &Keys::steps_per_ms},
            {"contact_time_s", &Keys::contact_time}};
  }
};

}  // namespace
}  // namespace tenon::test

int main(int argc, char** argv) {
  using namespace tenon;
  return apps::QuadrupedApp()
      .Customise<test::Keys>([](DiagramBuilder& builder, QuadrupedWalk& walk, const test::Keys& keys) {
        if (keys.engine == test::Engine::kMujoco)
          builder.Replace<test::MujocoQuadruped>(walk.world.plant, {.plant = walk.world.plant.params,
                                                                    .steps_per_ms = keys.steps_per_ms,
                                                                    .contact_time = keys.contact_time});
      })
      .Run(argc, argv);
}
