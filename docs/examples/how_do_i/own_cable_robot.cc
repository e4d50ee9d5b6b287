// Loads a custom cable robot from its file and holds it in the middle by its length controller.

#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/simulation.h>

#include <cmath>
#include <cstdio>

int main() {
  tenon::CdprLoopParams params;
  params.robot = tenon::LoadCdpr(ROBOT);
  params.path = std::make_shared<tenon::EquilibriumPath>(params.robot, tenon::Path::Hold({0, 0, 1}));
  params.pd_stiffness_N_per_m = 1000;
  params.pd_damping_N_s_per_m = 100;

  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::CdprLoop>("loop", params);
  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));
  simulator.RunTo(1);
  const tenon::CdprDescription& robot = loop.world.plant.params.robot;
  const auto& cables = simulator.context().Eval(loop.world.plant.cables);
  std::printf("'%s' of %g kg hangs on %d cables that pull with %.2f N each\n", robot.name.c_str(), robot.mass,
              robot.num_cables(), cables.tension[0]);
  // By symmetry each cable bears a quarter of the weight: T = m g / (4 sin of its slope), the cable from
  // (0.1, 0.1, 1.05) to (2, 2, 3).
  const double slope = 1.95 / std::sqrt(2 * 1.9 * 1.9 + 1.95 * 1.95);
  return std::abs(cables.tension[0] - robot.mass * 9.81 / (4 * slope)) < 0.1 ? 0 : 1;
}
