#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace tenon {
namespace {

void CheckPositive(const char* what, double value, const char* unit, const char* remedy) {
  if (!(std::isfinite(value) && value > 0))
    throw ParameterError(fmt::format("{} is {}{}{} but must be positive; {}", what, value,
                                     *unit == '\0' ? "" : " ", unit, remedy));
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
    throw ParameterError(fmt::format("cables has {} entries but must have at least {}; add cables",
                                     cables.size(), kMinCables));
  for (std::size_t i = 0; i < cables.size(); ++i) {
    const auto& [anchor, attachment] = cables[i];
    if (!anchor.allFinite() || !attachment.allFinite())
      throw ParameterError(fmt::format("cables.{} has a coordinate that is not finite; give all in m", i));
    constexpr double kFar = 1e4;  // m
    if (std::max(anchor.cwiseAbs().maxCoeff(), attachment.cwiseAbs().maxCoeff()) > kFar)
      throw ParameterError(fmt::format("cables.{} has a coordinate beyond {} m; is it in m?", i, kFar));
    if (anchor == attachment)
      throw ParameterError(
          fmt::format("cables.{} has zero length: anchor and attachment are both {}; "
                      "give the anchor in the world and the attachment from the platform's CoM",
                      i, Point(anchor)));
    for (std::size_t j = 0; j < i; ++j)
      if (anchor == cables[j].anchor_W && attachment == cables[j].attachment_B)
        throw ParameterError(
            fmt::format("cables.{} and {} both run from anchor {} to attachment {}; move or remove one", j, i,
                        Point(anchor), Point(attachment)));
  }
}

}  // namespace

void CableProperties::Validate() const {
  CheckPositive("axial_stiffness", axial_stiffness, "N", "give EA, Young's modulus times cross-section");
  CheckNotNegative("axial_damping", axial_damping, "N s", "give EA times the material's damping time");
  CheckNotNegative("mass_kg_per_m", mass_per_length, "kg/m", "give 0 for cables without weight");
  CheckNotNegative("tension_min", tension_min, "N", "a cable cannot push, give 0 or more");
  if (!(std::isfinite(tension_max) && tension_min < tension_max))
    throw ParameterError(fmt::format(
        "tension_min = {} N must be below tension_max = {} N; raise tension_max_N or lower tension_min_N",
        tension_min, tension_max));
}

void DrumProperties::Validate() const {
  CheckPositive("radius", radius, "m", "give that of the first layer, to the middle of the cable");
  CheckPositive("cable_diameter", cable_diameter, "m", "give that by which layers grow");
  CheckPositive("turns_per_layer", turns_per_layer, "", "give its width over the cable's diameter");
  CheckPositive("cable_length", cable_length, "m", "give all the cable that it has");
}

void DifferentialProperties::Validate() const {
  CheckPositive("motor_tension_max", motor_tension_max, "N",
                "give the motor's largest torque over the drum's radius");
  std::set<int> taken;
  for (const auto& [i, j] : pairs)
    for (const int cable : {i, j})
      if (cable < 0 || !taken.insert(cable).second)
        throw ParameterError(
            fmt::format("pairs: [{}, {}] names cable {}, which {}; give each cable from 0 once at most", i, j,
                        cable, cable < 0 ? "is none" : "is already in a pair"));
}

void WinchProperties::Validate() const {
  CheckPositive("time_constant", time_constant, "s", "give the lag of the motor's current loop");
  if (mode == WinchMode::kTension) {
    CheckPositive("reel_damping", reel_damping, "N s/m",
                  "in mode 'tension' give cable stiffness over the bandwidth of the tension loop in rad/s");
    CheckNotNegative("effective_mass", effective_mass, "kg", "give 0 or more");
  } else {
    CheckNotNegative("reel_damping", reel_damping, "N s/m", "give the friction at the drum");
    CheckPositive("effective_mass", effective_mass, "kg",
                  "mode 'torque' needs rotor inertia times gear ratio squared over drum radius squared");
  }
  CheckNotNegative("pulley_radius", pulley_radius, "m", "give 0 for a cable that leaves from a point");
  if (drum) drum->Validate();
  if (differential) differential->Validate();
}

void CdprDescription::Validate() const {
  CheckPositive("mass", mass, "kg", "give mass_kg above 0");
  constexpr double kMost = 1e6;  // kg
  if (mass > kMost)
    throw ParameterError(fmt::format("mass is {:.6g} kg but must be at most {} kg", mass, kMost));
  CheckInertia(inertia_B);
  CheckCables(cables);
  cable.Validate();
  winch.Validate();
  if (!winch.differential) return;
  for (const auto& [i, j] : winch.differential->pairs)
    if (std::max(i, j) >= num_cables())
      throw ParameterError(
          fmt::format("winch.differential.pairs: [{}, {}] names cable {}, but there are {}; give 0 to {}", i,
                      j, std::max(i, j), num_cables(), num_cables() - 1));
}

}  // namespace tenon
