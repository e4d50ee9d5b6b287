#include <tenon/apps/common/checks.h>
#include <tenon/apps/common/faults.h>
#include <tenon/apps/common/notes.h>
#include <tenon/apps/guide_dog/guide_dog_scenario.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

/// The robot alone.
QuadrupedScenario WithoutPerson(const GuideDogScenario& scenario) {
  QuadrupedScenario alone;
  alone.robot = scenario.robot;
  alone.duration_s = scenario.duration_s;
  alone.seed = scenario.seed;
  alone.terrain = scenario.terrain;
  alone.forces = scenario.forces;
  alone.walk = scenario.walk;
  alone.profile = scenario.profile;
  alone.hardware = scenario.hardware;
  alone.sensors = scenario.sensors;
  alone.fall = scenario.fall;
  alone.limit_speed = scenario.limit_speed;
  alone.integrator = scenario.integrator;
  alone.scale_forces = scenario.scale_forces;
  return alone;
}

}  // namespace

void GuideDogScenario::Validate() const {
  if (duration_s) DemandPositive("duration_s", *duration_s);
  DemandRate("log_rate_hz", log_rate_hz);
}

double Duration(const GuideDogScenario& scenario) {
  return Duration(WithoutPerson(scenario));
}

std::vector<std::string> Notes(const GuideDogScenario& scenario, double duration) {
  std::vector<std::string> notes;
  AddNotes(scenario.forces, duration, notes);
  AddNotes(scenario.faults, duration, notes);
  return notes;
}

GuideDogParams MakeGuideDogParams(const GuideDogScenario& scenario) {
  GuideDogParams params = MakeGuideDog(MakeWalkParams(WithoutPerson(scenario)));
  params.observer.kind = scenario.observer;
  params.supervisor.gains = scenario.supervisor;
  params.admittance.gains = scenario.admittance;
  params.obstacles = scenario.surroundings;
  params.person = scenario.person;
  params.leash = scenario.leash;
  const auto [weight, length] = RatioOf(WithoutPerson(scenario));
  SupervisorGains& supervisor = params.supervisor.gains;
  AdmittanceGains& admittance = params.admittance.gains;
  PersonParams& person = params.person;
  for (double* const force :
       {&supervisor.threshold, &supervisor.release, &admittance.desired_tension, &admittance.mass,
        &admittance.damping, &admittance.stiffness, &person.mass, &person.damping, &person.stiffness,
        &person.felt_tension, &params.leash.stiffness})
    *force *= weight;
  for (PersonPhase& phase : person.phases) phase.force *= weight;
  params.leash.attachment_B *= length;
  return params;
}

SimulatorOptions MakeSimulatorOptions(const GuideDogScenario& scenario) {
  return MakeSimulatorOptions(WithoutPerson(scenario));
}

}  // namespace tenon::apps
