#include <tenon/apps/guide_dog/guide_dog_scenario.h>

namespace tenon::apps {
namespace {

QuadrupedScenario WithoutPerson(const GuideDogScenario& scenario) {
  QuadrupedScenario alone;
  static_cast<LeggedScenario&>(alone) = scenario;
  alone.walk = scenario.walk;
  alone.observer = scenario.observer;
  return alone;
}

}  // namespace

double Duration(const GuideDogScenario& scenario) {
  return Duration(WithoutPerson(scenario));
}

GuideDogParams MakeGuideDogParams(const GuideDogScenario& scenario) {
  GuideDogParams params = MakeGuideDog(MakeWalkParams(WithoutPerson(scenario)));
  params.supervisor.gains = scenario.supervisor;
  params.admittance.gains = scenario.admittance;
  params.obstacles = scenario.surroundings;
  params.person = scenario.person;
  params.leash = scenario.leash;
  const auto [weight, length, offset] = RatioOf(scenario);
  SupervisorGains& supervisor = params.supervisor.gains;
  AdmittanceGains& admittance = params.admittance.gains;
  PersonParams& person = params.person;
  for (double* const force :
       {&supervisor.threshold, &supervisor.release, &supervisor.leash_stiffness, &admittance.desired_tension,
        &admittance.stiffness, &admittance.yield_tension, &person.mass, &person.damping, &person.stiffness,
        &person.felt_tension, &params.leash.stiffness})
    *force *= weight;
  admittance.mass *= weight;
  admittance.damping *= weight;
  for (PersonPhase& phase : person.phases) phase.force *= weight;
  params.leash.attachment_B = length * params.leash.attachment_B + offset;
  return params;
}

}  // namespace tenon::apps
