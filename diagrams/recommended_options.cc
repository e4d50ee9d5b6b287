#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/systems/framework/block/system.h>

#include <fmt/core.h>

#include <string>

namespace tenon {
void LeggedIntegration::Validate() const {
  Demand(method != LeggedIntegrator::kStabilized || order <= 3,
         fmt::format("order = {} must be 2 or 3 with the method 'stabilized'", order));
}

// Ticks restart the integrator every few milliseconds, and the plants declare their jumps. Open tables are
// sufficient then, and save one evaluation per tick.

SimulatorOptions LeggedIntegration::Options(const std::string& plant) const {
  const bool stabilized = method == LeggedIntegrator::kStabilized;
  return {.method = stabilized ? Method::kStabilized : Method::kErkOpen,
          .order = order,
          .rtol = rtol,
          .atol = atol_position,
          .state_atol = {{plant + ".motion.v_W", atol_velocity},
                         {plant + ".motion.w_W", atol_velocity},
                         {plant + ".motion.qd", atol_velocity},
                         {plant + ".bristles", atol_bristles}},
          .seed = kRecommendedSeed};
}

SimulatorOptions CdprIntegration::Options() const {
  return {.method = Method::kErkOpen, .order = order, .rtol = rtol, .atol = atol, .seed = kRecommendedSeed};
}

SimulatorOptions RecommendedOptions(const QuadrupedWorld& world) {
  const LeggedIntegration integration;
  SimulatorOptions options = integration.Options(world.plant.path());
  if (world.plant.additions.u.initial.size() > 0)
    options.state_atol.push_back({world.plant.path() + ".added_u", integration.atol_velocity});
  return options;
}
SimulatorOptions RecommendedOptions(const QuadrupedStand& stand) {
  return RecommendedOptions(stand.world);
}
SimulatorOptions RecommendedOptions(const QuadrupedWalk& walk) {
  return RecommendedOptions(walk.world);
}
SimulatorOptions RecommendedOptions(const CdprLoop&) {
  return CdprIntegration().Options();
}

}  // namespace tenon
