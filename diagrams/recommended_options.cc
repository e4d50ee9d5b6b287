#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>

#include <fmt/core.h>

namespace tenon {

void LeggedIntegration::Validate() const {
  Demand(method != LeggedIntegrator::kStabilized || order <= 3,
         fmt::format("order = {} must be 2 or 3 with the method 'stabilized'", order));
}

// Ticks restart the integrator every few milliseconds, and the plants declare their jumps. Open tables are
// sufficient then, and save one evaluation per tick.

SimulatorOptions LeggedIntegration::Options(const QuadrupedPlant& plant) const {
  const bool stabilized = method == LeggedIntegrator::kStabilized;
  SimulatorOptions options{.method = stabilized ? Method::kStabilized : Method::kErkOpen,
                           .order = order,
                           .rtol = rtol,
                           .atol = atol_position,
                           .seed = kRecommendedSeed};
  // A block in the place of the plant may lack a state.
  const auto add = [&](const Source& state, const std::string& part, double atol) {
    if (FindCurrent(state)) options.state_atol.push_back({state.path() + part, atol});
  };
  for (const char* part : {".v_W", ".w_W", ".qd"}) add(plant.motion, part, atol_velocity);
  add(plant.bristles, "", atol_bristles);
  if (const Source* const added = FindCurrent(plant.added_u); added && !added->spec().elements.empty())
    add(*added, "", atol_velocity);
  return options;
}

SimulatorOptions CdprIntegration::Options() const {
  return {.method = Method::kErkOpen, .order = order, .rtol = rtol, .atol = atol, .seed = kRecommendedSeed};
}

SimulatorOptions RecommendedOptions(const QuadrupedWorld& world) {
  return LeggedIntegration().Options(world.plant);
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
