#include "tenon/plants/description/cdpr_description.h"

#include <fmt/format.h>
#include <tenon/systems/errors.h>
#include <tenon/systems/yaml.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace tenon {
namespace {

/// Relative to the largest entry; files give inertias with a few digits.
constexpr double kInertiaTolerance = 1e-9;

void CheckPositive(const char* what, double value, const char* unit, const char* remedy) {
  if (!(std::isfinite(value) && value > 0))
    throw ParameterError(fmt::format("{} is {} {} but must be positive; {}", what, value, unit, remedy));
}

void CheckNotNegative(const char* what, double value, const char* unit, const char* remedy) {
  if (!(std::isfinite(value) && value >= 0))
    throw ParameterError(fmt::format("{} is {} {} but must not be negative; {}", what, value, unit, remedy));
}

void CheckInertia(const Eigen::Matrix3d& inertia) {
  const double tolerance = kInertiaTolerance * inertia.cwiseAbs().maxCoeff();
  if (!inertia.allFinite())
    throw ParameterError("the inertia has entries that are not finite; give all in kg m^2");
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < r; ++c)
      if (std::abs(inertia(r, c) - inertia(c, r)) > tolerance)
        throw ParameterError(fmt::format(
            "the inertia is not symmetric: row {} column {} is {} kg m^2, row {} column {} is {} kg m^2; "
            "give both the same value, the negative of the product of inertia",
            c, r, inertia(c, r), r, c, inertia(r, c)));

  const Eigen::Vector3d principal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  const std::string moments =
      fmt::format("{:.6g}, {:.6g}, {:.6g} kg m^2", principal[0], principal[1], principal[2]);
  if (principal[0] <= 0)
    throw ParameterError(
        fmt::format("the inertia is not positive definite: its principal moments are {}; "
                    "all must be positive, check signs and units",
                    moments));
  if (principal[0] + principal[1] < principal[2] - tolerance)
    throw ParameterError(fmt::format(
        "no rigid body has this inertia: its principal moments are {}, the largest above the sum of the "
        "other two; check the values and that they are about the CoM",
        moments));
}

std::string Point(const Eigen::Vector3d& p) {
  return fmt::format("({}, {}, {}) m", p[0], p[1], p[2]);
}

void CheckCables(const std::vector<CableDescription>& cables) {
  if (cables.size() < kMinCables || cables.size() > kMaxCables)
    throw ParameterError(fmt::format("the robot has {} cables but must have {} to {}; add or remove cables",
                                     cables.size(), kMinCables, kMaxCables));
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
  CheckNotNegative("the lowest tension", tension_min, "N", "a cable cannot push, give 0 or more");
  if (!(std::isfinite(tension_max) && tension_min < tension_max))
    throw ParameterError(fmt::format(
        "the lowest tension {} N must be below the highest, {} N; raise tension_max_N or lower tension_min_N",
        tension_min, tension_max));
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
}

void CdprDescription::Validate() const {
  CheckPositive("the platform's mass", mass, "kg", "give mass_kg above 0");
  CheckInertia(inertia_B);
  CheckCables(cables);
  cable.Validate();
  winch.Validate();
}

CdprDescription LoadCdpr(const std::filesystem::path& path) {
  return YamlDocument::Load(path).Read<CdprDescription>();
}

}  // namespace tenon
