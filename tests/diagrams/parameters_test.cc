// The parameters of the shipped diagrams, which a run can change.

#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/diagrams/cdpr/cdpr_test_loop.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <memory>
#include <set>
#include <string>
#include <utility>

namespace tenon::parameters_test {

QuadrupedWalkParams Walk() {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.walk.segments = {{.gait = Gait::kTrot, .forward = 0.1, .duration = 5}};
  params.world.pulses.push_back({});
  params.world.sines.push_back({});
  params.estimator.emplace();
  params.estimator->robot = test::DogBot();
  params.estimator->initial = params.world.plant.initial;
  return params;
}

GuideDogParams Dog() {
  const QuadrupedWalkParams walk = Walk();
  GuideDogParams params;
  params.world = walk.world;
  params.walk = walk.walk;
  params.locomotion = walk.locomotion;
  params.observer = walk.observer;
  params.person.phases = {{.activity = Activity::kFollow, .duration = 5, .speed = 0.1}};
  return params;
}

/// Lists, reads and sets all parameters without knowledge of the blocks, and returns their paths.
template <class Loop, class Params>
std::set<std::string> CheckParameters(const Params& params) {
  DiagramBuilder builder;
  builder.Add<Loop>("loop", params);
  const auto diagram = builder.Build();
  const auto context = diagram->CreateContext();
  std::set<std::string> paths;
  for (const auto* parameter : diagram->parameters()) {
    EXPECT_TRUE(paths.insert(parameter->path()).second) << parameter->path();
    EXPECT_EQ(parameter->elements().size(), parameter->initial_numbers().size()) << parameter->path();
    context->SetDoubles(*parameter, parameter->initial_numbers());
    EXPECT_EQ(context->EvalDoubles(*parameter), parameter->initial_numbers()) << parameter->path();
  }
  return paths;
}

TEST(ParametersTest, AllCanBeListedReadAndSet) {
  using ::testing::IsSupersetOf;
  EXPECT_THAT(CheckParameters<QuadrupedWalk>(Walk()),
              IsSupersetOf({"loop.locomotion.whole_body.gains", "loop.locomotion.swing_planner.step",
                            "loop.locomotion.scheduler.gaits", "loop.observer.legs.gains",
                            "loop.observer.com.gains", "loop.estimator.noise"}));
  EXPECT_THAT(CheckParameters<GuideDog>(Dog()),
              IsSupersetOf({"loop.supervisor.gains", "loop.admittance.gains", "loop.leash.stiffness",
                            "loop.person.phases"}));
  EXPECT_TRUE(CheckParameters<CdprLoop>(test::CircleWithPd()).contains("loop.pd.stiffness"));
  EXPECT_THAT(CheckParameters<CdprLoop>(test::CircleWithMpc()),
              IsSupersetOf({"loop.mpc.weights", "loop.estimator.noise", "loop.imu.specific_force_bias"}));
}

// New gains act from the next tick of the controller on.
TEST(ParametersTest, AWalkGoesOnWithOtherGains) {
  const auto torque = [](bool changes) {
    DiagramBuilder builder;
    const auto& loop = builder.Add<QuadrupedWalk>("loop", Walk());
    Simulator simulator(builder.Build(), {.order = 2, .rtol = 1e-2, .atol = 1e-3});
    const WholeBodyController& controller = loop.locomotion.whole_body;
    simulator.RunTo(0.3);
    const Vec<12> before = simulator.context().Eval(controller.torque);
    if (changes) {
      WholeBodyGains gains = simulator.context().Eval(controller.gains);
      gains.trunk_stiffness /= 2;
      simulator.context().Set(controller.gains, gains);
      EXPECT_EQ(simulator.context().Eval(controller.torque), before) << "held until its tick";
    }
    simulator.RunTo(0.4);
    if (AllocationGuard::Available()) {
      const AllocationGuard guard;
      simulator.RunTo(0.45);
      EXPECT_EQ(guard.count(), 0);
    }
    return std::pair(before, simulator.context().Eval(controller.torque));
  };
  const auto plain = torque(false), changed = torque(true);
  EXPECT_EQ(changed.first, plain.first);
  EXPECT_NE(changed.second, plain.second);
}

}  // namespace tenon::parameters_test
