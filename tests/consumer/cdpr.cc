// A cable robot that holds its place, from the installed package.

#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/simulation.h>
#include <tenon/systems/yaml/resources.h>

#include <cstdio>

int main() {
  tenon::CdprLoopParams params;
  params.robot = tenon::LoadCdpr(tenon::FindResource("robots", "cdpr_4"));
  params.path = std::make_shared<tenon::EquilibriumPath>(params.robot, tenon::Path::Hold({0, 0, 2}));
  params.pd_stiffness_N_per_m = 2000;
  params.pd_damping_N_s_per_m = 200;

  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::CdprLoop>("loop", params);
  const auto diagram = builder.Build();
  tenon::Simulator simulator(*diagram, tenon::RecommendedOptions(loop));
  simulator.RunTo(1);
  const Eigen::Vector3d p = simulator.context().Eval(loop.world.plant.platform).p_WB;
  std::printf("the platform hangs at (%.4f, %.4f, %.4f) m\n", p[0], p[1], p[2]);
  return (p - Eigen::Vector3d(0, 0, 2)).norm() < 1e-3 ? 0 : 1;
}
