#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/plants/attached_bodies.h>

#include <fmt/core.h>

namespace tenon::apps {

void RandomForceScenario::Validate() const {
  Demand(std::isfinite(upper_N) && upper_N >= lower_N,
         fmt::format("upper_N = {} must not be below lower_N = {}", upper_N, lower_N));
}

RigidInertia TrunkLoadScenario::Make() const {
  return UniformBoxInertia(mass_kg, position_m, edges_m);
}

FieldList WalkTask::Fields() {
  FieldList fields = Task::Fields();
  fields.push_back({"arrives", &WalkTask::arrives});
  return fields;
}

FieldList QuadrupedScenario::Fields() {
  using S = QuadrupedScenario;
  FieldList fields = LeggedScenario::Fields();
  fields.insert(
      fields.end(),
      {Field("start_height_m", &S::start_height_m).AtLeast(0).Because("below 0 the feet start in the ground"),
       {"pd", &S::pd},
       {"walk", &S::walk},
       {"deployment", &S::deployment},
       {"observer", &S::observer},
       {"random_forces", &S::random_forces},
       {"ropes", &S::ropes},
       {"payload", &S::payload},
       {"attached", &S::attached},
       {"known_additions", &S::known_additions},
       {"task", &S::task},
       {"compare", &S::compare},
       Field("log_rate_hz", &S::log_rate_hz).In(Rates())});
  return fields;
}

std::vector<RenamedKey> QuadrupedScenario::Renamed() {
  return {{"sweep", "forces.0.start_s and forces.0.turn_rad, which a campaign varies, see cases_pushes"}};
}

void QuadrupedScenario::Validate() const {
  Demand(!pd || !walk, "pd and walk are both given: set pd to null for a walk, or walk to null for standing");
  Demand(pd || walk, "neither pd nor walk is given: give pd for a robot that stands, or walk");
  Demand(ropes.empty() || walk,
         "ropes: a standing robot has no control of the tensions; give walk, or no ropes");
  Demand(!deployment || walk, "deployment: only a walk has a supervisor; give walk, or set it to null");
  if (!ropes.empty()) CheckRopes(ropes);
  // One force is reserved for QuadrupedWorld::pull, and one for a load that slides.
  const std::size_t most = kMaxExternalForces - (payload.slides ? 2 : 1);
  const std::size_t num_forces = forces.size() + random_forces.size();
  Demand(num_forces <= most,
         fmt::format("{}: {} forces (forces and random_forces) are too many, at most {} are possible",
                     forces.empty() ? "random_forces" : "forces", num_forces, most));
}

double Duration(const QuadrupedScenario& scenario) {
  if (scenario.duration_s) return *scenario.duration_s;
  return scenario.walk ? EndOfWalk(*scenario.walk) + 1 : 10;
}

}  // namespace tenon::apps
