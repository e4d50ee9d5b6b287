// A run of a shipped diagram, also with bodies that Simbody moves, gives the same numbers in every thread, in
// a clone, and after its context is restored.

#include <tenon/plants/attached_bodies.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/tests/diagrams/cdpr/cdpr_test_loop.h>
#include <tenon/tests/diagrams/legged/trot_recording.h>
#include <tenon/tests/testing/block_test.h>

#include <cfenv>
#include <thread>

namespace tenon::repeatable_test {

template <class Loop>
std::shared_ptr<const Diagram> MakeDiagram(const auto& params) {
  DiagramBuilder builder;
  builder.Add<Loop>("loop", params);
  return builder.Build();
}

/// A trot that uses the state estimator and the ZMP spline.
QuadrupedWalkParams Trot() {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.locomotion.com_planner.reference = ComReference::kZmpSpline;
  params.walk.segments = {{.duration = 0.3}, {.gait = Gait::kTrot, .forward = 0.12, .duration = 10}};
  params.estimator.emplace();
  params.estimator->robot = params.world.plant.robot;
  params.estimator->initial = params.world.plant.initial;
  return params;
}

struct Case {
  std::string name;
  std::shared_ptr<const Diagram> diagram;
  SimulatorOptions options;
  friend void PrintTo(const Case& shipped, std::ostream* out) { *out << shipped.name; }
};
std::vector<Case> Cases() {
  const SimulatorOptions cables{.order = 2, .rtol = 1e-3, .atol = 1e-5};
  const std::vector<AttachedBody> load{
      {.name = "load", .position = {0, 0, 0.1}, .mass = 0.5, .centre = {0.2, 0, 0}, .radius = 0.05}};
  CdprLoopParams flight = test::CircleWithPd();
  flight.extend = AttachToPlatform(load);
  QuadrupedWalkParams walk = Trot();
  walk.world.plant.extend = Attach(load);
  return {{"pd", MakeDiagram<CdprLoop>(test::CircleWithPd()), cables},
          {"pd with a load", MakeDiagram<CdprLoop>(flight), cables},
          {"mpc", MakeDiagram<CdprLoop>(test::CircleWithMpc()), cables},
          {"trot", MakeDiagram<QuadrupedWalk>(Trot()), test::TrotLoop::Options()},
          {"trot with a load", MakeDiagram<QuadrupedWalk>(walk), test::TrotLoop::Options()}};
}

Eigen::VectorXd EndOf(Simulator& simulator, double time) {
  simulator.RunTo(time);
  return simulator.context().continuous_state();
}

TEST(RepeatableTest, ThreadsGiveTheNumbersOfOne) {
  for (const Case& each : Cases()) {
    const auto run = [&](Eigen::VectorXd* end) {
      Simulator simulator(*each.diagram, each.options);
      *end = EndOf(simulator, 0.6);
    };
    Eigen::VectorXd alone, first, second;
    run(&alone);
    std::thread one(run, &first), two(run, &second);
    one.join();
    two.join();
    EXPECT_EQ(first, alone) << each.name;
    EXPECT_EQ(second, alone) << each.name;
  }
}

// 0.385 s is a tick of the controllers of the cable robot; the other times lie between their ticks.
TEST(RepeatableTest, ARestoredOrClonedRunGoesOnBitForBit) {
  for (const auto& [name, diagram, options] : Cases()) {
    for (const double pause : {0.001, 0.333, 0.385}) {
      Simulator straight(*diagram, options);
      straight.RunTo(pause);
      auto context = diagram->CreateContext();
      context->Restore(straight.context().Save());
      Simulator restored(std::move(context), options), cloned(straight.context().Clone(), options),
          fresh(*diagram, options);
      const Eigen::VectorXd end = EndOf(fresh, 0.6);
      EXPECT_EQ(EndOf(restored, 0.6), end) << name << ", saved at " << pause << " s";
      EXPECT_EQ(EndOf(cloned, 0.6), end) << name << ", cloned at " << pause << " s";
    }
  }
}

/// Lets invalid operations, divisions by zero and overflows end the program by SIGFPE during its lifetime.
class Traps {
 public:
  Traps() { feenableexcept(kTrapped); }
  ~Traps() { fedisableexcept(kTrapped); }

 private:
  static constexpr int kTrapped = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;
};

TEST(RepeatableTest, NothingTrapsInAProgramThatEnablesTraps) {
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
  GTEST_SKIP() << "Clang, which compiles the library for sanitizers, may compute what the source does not";
#endif
#endif
  const Traps traps;
  for (const auto& [name, diagram, options] : Cases()) Simulator(*diagram, options).RunTo(0.6);
  // Without ticks, nothing limits the steps.
  DiagramBuilder builder;
  auto& integrator = builder.Add<Integrator<>>("integrator", {.initial = 3});
  builder.Connect(integrator.y, integrator.u);
  const auto growth = builder.Build();
  Simulator(*growth).RunTo(1);
}

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
    EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(0.45); }), 0);
    return std::pair(before, simulator.context().Eval(controller.torque));
  };
  const auto plain = torque(false), changed = torque(true);
  EXPECT_EQ(changed.first, plain.first);
  EXPECT_NE(changed.second, plain.second);
}

}  // namespace tenon::repeatable_test
