#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/plants/legged/disturbances.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/report/report.h>
#include <tenon/systems/simulation.h>
#include <tenon/systems/yaml/resources.h>

#include "momentum_observer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

tenon::WalkSegment Trot(double length, double yaw_rate = 0) {
  return {.gait = tenon::Gait::kTrot, .forward = 0.12, .yaw_rate = yaw_rate, .length = length};
}

tenon::QuadrupedWalkParams MakeA1(const tenon::QuadrupedDescription& robot) {
  tenon::QuadrupedWalkParams a1 = tenon::MakeQuadrupedWalk(robot);
  a1.walk.segments = {{.gait = tenon::Gait::kStand, .duration = 0.5},
                      Trot(1.5),
                      Trot(1.25, 0.05),
                      Trot(1),
                      Trot(1.25, -0.05),
                      Trot(0.5)};
  tenon::ExternalForce knee = tenon::PointOnLeg(robot, tenon::kFrontLeft, 0.5);
  knee.force_W << 20, 0, 0;
  a1.world.sines = {{.amplitude = knee, .angular_frequency = 1, .start = 0, .end = 100}};
  return a1;
}

const std::vector<tenon::Plot> kPlots = {{.title = "error of the CoM", .signals = {"loop.errors.errors.com"}},
                                         {.title = "force on the robot and, dashed, its estimate",
                                          .signals = {"loop.world.plant.external_wrench.force_W"},
                                          .references = {"loop.observer.wrench.force_W"}}};

tenon::Report Run(const std::string& name, bool own) {
  const tenon::QuadrupedDescription robot = tenon::LoadQuadruped(tenon::FindResource("robots", "dogbot"));
  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", MakeA1(robot));
  if (own) builder.Replace<MomentumObserver>(loop.observer, {.robot = robot});
  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));

  tenon::Report report({.title = "A1, " + name, .plots = kPlots});
  report.Log(simulator,
             {&loop.errors.errors, &loop.world.plant.external_wrench, &tenon::Current(loop.observer.wrench)},
             {&loop.world.plant.geometry, &loop.view.geometry});
  const auto log = simulator.AddLog(tenon::Hz(1000), {&loop.errors.errors});
  const tenon::RunStatus status = simulator.AdvanceTo(loop.walk.end_time() + 1);

  const std::vector<double> x = log->column("loop.errors.errors.com.x");
  const std::vector<double> y = log->column("loop.errors.errors.com.y");
  const std::vector<double> z = log->column("loop.errors.errors.com.z");
  double largest = 0;
  for (std::size_t i = 0; i < x.size(); ++i) largest = std::max(largest, std::hypot(x[i], y[i], z[i]));
  std::printf("%s: %s after %.2f s, CoM error at most %.2f mm\n", name.c_str(),
              status.ended ? status.reason.c_str() : "finished", status.time, 1000 * largest);
  report.AddFigure("com_error_max_m", largest);
  report.Conclude(status);
  return report;
}

int main() {
  const tenon::Report shipped = Run("shipped", false);
  const tenon::Report own = Run("own", true);
  tenon::Report both({.title = "A1: the shipped observer and ours", .plots = kPlots});
  both.Add("shipped", shipped);
  both.Add("own", own);
  both.Write("report.html");
}
