// Hangs a load of 2 kg from the trunk of the shipped walking robot, on a rod that swings. The controller does
// not know it.

#include <tenon/plants/legged/quadruped_multibody.h>

#include "walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

int main() {
  tenon::QuadrupedWalkParams params = TrotParams();
  params.world.plant.extend = [](tenon::QuadrupedMultibody& robot) {
    using SimTK::Vec3;  // all in kg and m
    const SimTK::Body::Rigid load(SimTK::MassProperties(2, Vec3(0), SimTK::UnitInertia::sphere(0.05)));
    const SimTK::MobilizedBody::Universal swing(robot.trunk(), Vec3(0), load, Vec3(0, 0, 0.2));
    SimTK::Force::MobilityLinearDamper(robot.forces, swing, SimTK::MobilizerUIndex(0), 0.02);
    SimTK::Force::MobilityLinearDamper(robot.forces, swing, SimTK::MobilizerUIndex(1), 0.02);
    robot.Name(swing, "swing");
    robot.Draw(swing, tenon::Shape::Sphere(tenon::ShapeRole::kLoad, "load", 0.05));
  };

  tenon::DiagramBuilder builder;
  auto& loop = builder.Add<tenon::QuadrupedWalk>("loop", params);
  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(loop));
  const auto log = simulator.AddLog(tenon::Hz(100), {&loop.world.plant.added_positions});
  const int code = WalkFor(3, simulator, loop);
  double widest = 0;
  for (std::size_t i = 0; i < log->rows(); ++i) widest = std::max(widest, std::abs(log->row(i)[2]));
  std::printf("the load swung by %.1f degrees forwards or backwards\n", widest * 180 / std::numbers::pi);
  return code;
}
