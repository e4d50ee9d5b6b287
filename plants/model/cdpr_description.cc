#include <tenon/plants/model/cdpr_description.h>

#include <fmt/format.h>
#include <tenon/plants/model/resources.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/systems/framework/errors.h>
#include <tenon/systems/yaml/yaml.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace tenon {
namespace {

void CheckPositive(const char* what, double value, const char* unit, const char* remedy) {
  if (!(std::isfinite(value) && value > 0))
    throw ParameterError(fmt::format("{} is {} {} but must be positive; {}", what, value, unit, remedy));
}

void CheckNotNegative(const char* what, double value, const char* unit, const char* remedy) {
  if (!(std::isfinite(value) && value >= 0))
    throw ParameterError(fmt::format("{} is {} {} but must not be negative; {}", what, value, unit, remedy));
}

std::string Point(const Eigen::Vector3d& p) {
  return fmt::format("({}, {}, {}) m", p[0], p[1], p[2]);
}

void CheckCables(const std::vector<CableDescription>& cables) {
  if (cables.size() < kMinCables)
    throw ParameterError(fmt::format("the robot has {} cables but must have at least {}; add cables",
                                     cables.size(), kMinCables));
  for (std::size_t i = 0; i < cables.size(); ++i) {
    const auto& [anchor, attachment] = cables[i];
    if (!anchor.allFinite() || !attachment.allFinite())
      throw ParameterError(fmt::format("cable {} has a coordinate that is not finite; give all in m", i));
    if (anchor == attachment)
      throw ParameterError(
          fmt::format("cable {} has zero length: anchor and attachment are both {}; "
                      "give the anchor in the world and the attachment from the platform's CoM",
                      i, Point(anchor)));
    for (std::size_t j = 0; j < i; ++j)
      if (anchor == cables[j].anchor_W && attachment == cables[j].attachment_B)
        throw ParameterError(
            fmt::format("cables {} and {} both run from anchor {} to attachment {}; move or remove one", j, i,
                        Point(anchor), Point(attachment)));
  }
}

}  // namespace

void CableProperties::Validate() const {
  CheckPositive("the axial stiffness", axial_stiffness, "N", "give EA, Young's modulus times cross-section");
  CheckNotNegative("the axial damping", axial_damping, "N s", "give EA times the material's damping time");
  CheckNotNegative("the cable's mass per length", mass_per_length, "kg/m",
                   "give 0 for cables without weight");
  CheckNotNegative("the lowest tension", tension_min, "N", "a cable cannot push, give 0 or more");
  if (!(std::isfinite(tension_max) && tension_min < tension_max))
    throw ParameterError(fmt::format(
        "the lowest tension {} N must be below the highest, {} N; raise tension_max_N or lower tension_min_N",
        tension_min, tension_max));
}

void DrumProperties::Validate() const {
  CheckPositive("the drum's radius", radius, "m", "give that of the first layer, to the middle of the cable");
  CheckPositive("the cable's diameter", cable_diameter, "m", "give that by which layers grow");
  CheckPositive("the drum's turns per layer", turns_per_layer, "",
                "give its width over the cable's diameter");
  CheckPositive("the drum's cable length", cable_length, "m", "give all the cable that it has");
}

void DifferentialProperties::Validate() const {
  CheckPositive("the differential's motor tension", motor_tension_max, "N",
                "give the motor's largest torque over the drum's radius");
  std::set<int> taken;
  for (const auto& [i, j] : pairs)
    for (const int cable : {i, j})
      if (cable < 0 || !taken.insert(cable).second)
        throw ParameterError(fmt::format(
            "the differential's pair [{}, {}] names cable {}, which {}; give each cable from 0 once at most",
            i, j, cable, cable < 0 ? "is none" : "is already in a pair"));
}

void WinchProperties::Validate() const {
  CheckPositive("the winch's time constant", time_constant, "s", "give the lag of the motor's current loop");
  if (mode == WinchMode::kTension) {
    CheckPositive("the winch's reel damping", reel_damping, "N s/m",
                  "in mode 'tension' give cable stiffness over the bandwidth of the tension loop in rad/s");
    CheckNotNegative("the winch's effective mass", effective_mass, "kg", "give 0 or more");
  } else {
    CheckNotNegative("the winch's reel damping", reel_damping, "N s/m", "give the friction at the drum");
    CheckPositive("the winch's effective mass", effective_mass, "kg",
                  "mode 'torque' needs rotor inertia times gear ratio squared over drum radius squared");
  }
  CheckNotNegative("the pulley's radius", pulley_radius, "m", "give 0 for a cable that leaves from a point");
  if (drum) drum->Validate();
  if (differential) differential->Validate();
}

void CdprDescription::Validate() const {
  CheckPositive("the platform's mass", mass, "kg", "give mass_kg above 0");
  CheckInertia(inertia_B);
  CheckCables(cables);
  cable.Validate();
  winch.Validate();
  if (!winch.differential) return;
  for (const auto& [i, j] : winch.differential->pairs)
    if (std::max(i, j) >= num_cables())
      throw ParameterError(
          fmt::format("the differential's pair [{}, {}] names cable {}, but there are {}; give 0 to {}", i, j,
                      std::max(i, j), num_cables(), num_cables() - 1));
}

void CheckNumCables(int num_cables, Eigen::Index num, const char* who) {
  if (num == num_cables) return;
  throw RunError(
      fmt::format("{} gets signals of {} cables, but its num_cables is {}: give it that of the robot.", who,
                  num, num_cables));
}

CdprDescription LoadCdpr(const std::string& path) {
  return YamlDocument::Load(path).Read<CdprDescription>();
}

CdprDescription LoadCdpr(const YamlFile& what) {
  return LoadResource("robots", what, "cables").Read<CdprDescription>();
}

}  // namespace tenon
