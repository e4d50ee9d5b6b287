// A user's observer in the loop of a walking quadruped, from the installed package: a spring balance that
// estimates a vertical force from the height of the trunk.

#include <tenon/diagrams/legged/legged_locomotion.h>
#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/simulation.h>
#include <tenon/systems/yaml/resources.h>

#include <cstdio>

struct BalanceParams {
  tenon::QuadrupedDescription robot;
  double stiffness = 2500;  // N/m
};
class Balance final : public tenon::LeafSystem<BalanceParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::LeggedState> state{this, {"state"}};
  tenon::OutputPort<tenon::WrenchEstimate> wrench{
      this, {"wrench"}, tenon::Sampled{tenon::Hz(1000)}, tenon::Uses(state), &Balance::CalcWrench};

 private:
  tenon::WrenchEstimate CalcWrench(const tenon::LeggedState& x) const {
    tenon::WrenchEstimate wrench;
    wrench.force_W[2] = params.stiffness * (x.p_WB[2] - params.robot.StanceHeight());
    return wrench;
  }
};

int main() {
  const tenon::QuadrupedDescription robot = tenon::LoadQuadruped(tenon::FindResource("robots", "dogbot"));
  const tenon::QuadrupedWalkParams walk = tenon::MakeQuadrupedWalk(robot);

  tenon::DiagramBuilder builder;
  auto& world = builder.Add<tenon::QuadrupedWorld>("world", walk.world);
  auto& locomotion = builder.Add<tenon::LeggedLocomotion>("locomotion", walk.locomotion);
  auto& balance = builder.Add<Balance>("balance", BalanceParams{.robot = robot});
  auto& command = builder.AddFunction({"command"}, tenon::Uses(builder.time), [](double t) {
    return tenon::WalkCommand{.gait = t < 0.3 ? tenon::Gait::kStand : tenon::Gait::kTrot, .forward = 0.1};
  });
  builder.Connect(command, locomotion.command);
  builder.Connect(world.state, locomotion.state);
  builder.Connect(world.foot_forces, locomotion.foot_forces);
  builder.Connect(world.state, balance.state);
  builder.Connect(balance.wrench, locomotion.wrench);
  builder.Connect(locomotion.torque, world.torque);
  const auto diagram = builder.Build();

  tenon::Simulator simulator(*diagram, tenon::RecommendedOptions(world));
  const bool fell = simulator.AdvanceTo(1.5).ended;
  const double x = simulator.context().Eval(world.state).p_WB[0];
  std::printf("walked %.3f m\n", x);
  return !fell && x > 0.05 ? 0 : 1;
}
