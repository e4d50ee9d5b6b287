#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/model/swivel_pulley.h>
#include <tenon/plants/model/vectors.h>

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <set>

namespace tenon {
namespace {

constexpr double kFar = 1e4;                 // largest coordinate [m]
constexpr double kPlatformThickness = 0.04;  // least thickness, for attachments in one plane [m]

void CheckPositive(const char* what, double value, const char* unit, const char* remedy) {
  if (!(std::isfinite(value) && value > 0))
    throw ParameterError(fmt::format("{} is {}{}{} but must be positive; {}", what, value,
                                     *unit == '\0' ? "" : " ", unit, remedy));
}

std::string Point(const Eigen::Vector3d& p) {
  return fmt::format("({}, {}, {}) m", p[0], p[1], p[2]);
}

void CheckCables(const std::vector<CableDescription>& cables) {
  if (cables.size() < kMinCables)
    throw ParameterError(fmt::format("cables has {} entries but must have at least {}; add cables",
                                     cables.size(), kMinCables));
  for (std::size_t i = 0; i < cables.size(); ++i) {
    const Eigen::Vector3d &anchor = cables[i].anchor_W, &attachment = cables[i].attachment_B;
    if (!anchor.allFinite() || !attachment.allFinite())
      throw ParameterError(fmt::format("cables.{} has a coordinate that is not finite; give all in m", i));
    if (std::max(anchor.cwiseAbs().maxCoeff(), attachment.cwiseAbs().maxCoeff()) > kFar)
      throw ParameterError(fmt::format("cables.{} has a coordinate beyond {} m; is it in m?", i, kFar));
    for (std::size_t j = 0; j < i; ++j)
      if (anchor == cables[j].anchor_W && attachment == cables[j].attachment_B)
        throw ParameterError(
            fmt::format("cables.{} and {} both run from anchor {} to attachment {}; move or remove one", j, i,
                        Point(anchor), Point(attachment)));
  }
}

}  // namespace

void AnchorPath::Validate() const {
  const std::size_t count = times.size();
  if (count < 2 || offsets.size() != count)
    throw ParameterError(fmt::format(
        "times_s has {} entries and offsets_m has {}; give one displacement per time, and two or more", count,
        offsets.size()));
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(times[i]) || times[i] < 0 || (i > 0 && times[i] <= times[i - 1]))
      throw ParameterError(
          fmt::format("times_s.{} = {}: the times must begin at 0 or later and increase", i, times[i]));
    if (!offsets[i].allFinite() || offsets[i].cwiseAbs().maxCoeff() > kFar)
      throw ParameterError(
          fmt::format("offsets_m.{} is {}; give three numbers up to {} m", i, Point(offsets[i]), kFar));
  }
  if (!offsets.front().isZero(0))
    throw ParameterError(
        fmt::format("offsets_m.0 is {}, but the anchor begins at anchor_m; give [0, 0, 0] and move anchor_m",
                    Point(offsets.front())));
}

void CableProperties::Validate() const {
  CheckRanges(*this);
  if (tension_min >= tension_max)
    throw ParameterError(fmt::format(
        "tension_min = {} N must be below tension_max = {} N; raise tension_max_N or lower tension_min_N",
        tension_min, tension_max));
}

void DifferentialProperties::Validate() const {
  std::set<int> taken;
  for (const auto& [i, j] : pairs)
    for (const int cable : {i, j})
      if (cable < 0 || !taken.insert(cable).second)
        throw ParameterError(
            fmt::format("pairs: [{}, {}] names cable {}, which {}; give each cable from 0 once at most", i, j,
                        cable, cable < 0 ? "is none" : "is already in a pair"));
}

void WinchProperties::Validate() const {
  if (mode == WinchMode::kTension)
    CheckPositive("reel_damping", reel_damping, "N s/m",
                  "in mode 'tension' give cable stiffness over the bandwidth of the tension loop in rad/s");
  else
    CheckPositive("effective_mass", effective_mass, "kg",
                  "mode 'torque' needs rotor inertia times gear ratio squared over drum radius squared");
  if (differential) differential->Validate();
}

double CdprDescription::tension_min(Eigen::Index i) const {
  return cables[i].tension_min.value_or(cable.tension_min);
}

double CdprDescription::tension_max(Eigen::Index i) const {
  return cables[i].tension_max.value_or(cable.tension_max);
}

double CdprDescription::pulley_radius(Eigen::Index i) const {
  return cables[i].pulley_radius.value_or(winch.pulley_radius);
}

bool CdprDescription::has_pulleys() const {
  return std::ranges::any_of(
      cables, [this](const auto& each) { return each.pulley_radius.value_or(winch.pulley_radius) > 0; });
}

bool CdprDescription::carries_pulley(Eigen::Index i) const {
  return winch.pulleys_on_platform && pulley_radius(i) > 0;
}

void CdprDescription::RemovePulleys() {
  winch.pulley_radius = 0;
  for (CableDescription& each : cables) each.pulley_radius.reset();
}

bool CdprDescription::ends_in_one_point() const {
  const auto at_point = [this](const auto& each) { return each.attachment_B == cables[0].attachment_B; };
  return std::ranges::all_of(cables, at_point) && std::ranges::all_of(springs, at_point);
}

CableVector CdprDescription::tension_min() const {
  return CableVector::NullaryExpr(num_cables(), [this](Eigen::Index i) { return tension_min(i); });
}

CableVector CdprDescription::tension_max() const {
  return CableVector::NullaryExpr(num_cables(), [this](Eigen::Index i) { return tension_max(i); });
}

void CdprDescription::LimitTension(CableVector* tension) const {
  for (Eigen::Index i = 0; i < tension->size(); ++i)
    (*tension)[i] = std::min(std::max((*tension)[i], tension_min(i)), tension_max(i));
}

void CdprDescription::Validate() const {
  CheckRanges(*this);
  CheckInertia(inertia_B);
  CheckCables(cables);
  for (std::size_t i = 0; i < cables.size(); ++i)
    if (cables[i].anchor_path) {
      try {
        cables[i].anchor_path->Validate();
      } catch (const ParameterError& error) {
        throw ParameterError(fmt::format("cables.{}.anchor_path.{}", i, error.what()));
      }
    }
  cable.Validate();
  for (int i = 0; i < num_cables(); ++i)
    if (tension_min(i) >= tension_max(i))
      throw ParameterError(
          fmt::format("cables.{}: tension_min = {} N must be below tension_max = {} N; raise its "
                      "tension_max_N or lower its tension_min_N, or those of cable_properties",
                      i, tension_min(i), tension_max(i)));
  winch.Validate();
  const auto level = [this](const auto& each) {
    return each.anchor_W.z() == cables[0].anchor_W.z() && each.attachment_B.z() == 0;
  };
  const auto moves = [](const CableDescription& each) { return each.anchor_path.has_value(); };
  if (on_table && (!std::ranges::all_of(cables, level) || !std::ranges::all_of(springs, level) ||
                   std::ranges::any_of(cables, moves) || has_pulleys() || cable.mass_per_length > 0))
    throw ParameterError(
        "on_table is true, but the cables or springs are not level; give all anchors the same z and all "
        "attachments z = 0, and no anchor_path, pulley_radius_m or mass_kg_per_m");
  if (winch.pulleys_on_platform && has_pulleys() && cable.mass_per_length > 0)
    throw ParameterError(
        "winch.pulleys_on_platform: only cables without mass leave the platform over pulleys; remove "
        "mass_kg_per_m or pulleys_on_platform");
  if (!winch.differential) return;
  for (const auto& [i, j] : winch.differential->pairs)
    if (std::max(i, j) >= num_cables())
      throw ParameterError(
          fmt::format("winch.differential.pairs: [{}, {}] names cable {}, but there are {}; give 0 to {}", i,
                      j, std::max(i, j), num_cables(), num_cables() - 1));
}

Eigen::Matrix<double, 6, 1> CalcSpringWrench(const std::vector<SpringDescription>& springs,
                                             const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                                             Eigen::Matrix<double, 6, 6>* jacobian) {
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
  if (jacobian) jacobian->setZero();
  for (std::size_t i = 0; i < springs.size(); ++i) {
    const auto& [anchor_W, attachment_B, k, rest_length] = springs[i];
    const Eigen::Vector3d arm = R_WB * attachment_B, span = anchor_W - p_WB - arm;
    const double length = span.norm();
    if (length == 0 && rest_length > 0)
      throw RunError(fmt::format(
          "springs.{} has no direction: its attachment is at its anchor ({:.4g}, {:.4g}, {:.4g}) m; keep the "
          "platform away from it, or give rest_length_m 0",
          i, anchor_W.x(), anchor_W.y(), anchor_W.z()));
    const double compression = rest_length > 0 ? k * rest_length / length : 0;  // k l0 / l
    const Eigen::Vector3d force = (k - compression) * span;
    wrench.head<3>() += force;
    wrench.tail<3>() += arm.cross(force);
    if (!jacobian) continue;
    // If the attachment moves by d, the force changes by -stiffness d.
    Eigen::Matrix3d stiffness = (k - compression) * Eigen::Matrix3d::Identity();
    if (compression > 0) stiffness += compression / (length * length) * span * span.transpose();
    const Eigen::Matrix3d cross = CrossMatrix(arm), by_turn = stiffness * cross;
    jacobian->topLeftCorner<3, 3>() -= stiffness;
    jacobian->bottomLeftCorner<3, 3>() -= cross * stiffness;
    jacobian->topRightCorner<3, 3>() += by_turn;
    jacobian->bottomRightCorner<3, 3>() += cross * by_turn + CrossMatrix(force) * cross;
  }
  return wrench;
}

double CalcSpringEnergy(const std::vector<SpringDescription>& springs, const Eigen::Vector3d& p_WB,
                        const Eigen::Matrix3d& R_WB) {
  double energy = 0;
  for (const SpringDescription& spring : springs)
    energy += spring.stiffness / 2 *
              std::pow((spring.anchor_W - p_WB - R_WB * spring.attachment_B).norm() - spring.rest_length, 2);
  return energy;
}

double WrapOf(double x, double z) {
  const double angle = std::atan2(x, z);
  return angle < -std::numbers::pi / 2 ? angle + 2 * std::numbers::pi : angle;
}

PulleyContact LeaveStraight(double radius, double x, double z) {
  const double free_length = std::sqrt((x - radius) * (x - radius) + z * z - radius * radius);
  return {WrapOf(x - radius, z) + std::atan2(radius, free_length), free_length};
}

Vec<2> ExitPoint(double radius, double wrap) {
  return {radius * (1 - std::cos(wrap)), radius * std::sin(wrap)};
}

StraightLead LeadStraight(double radius, const Vec<3>& span_W) {
  const double x = std::hypot(span_W[0], span_W[1]);
  const PulleyContact contact = LeaveStraight(radius, x, -span_W[2]);
  const Vec<2> exit = ExitPoint(radius, contact.wrap);
  const Vec<3> outwards = Vec<3>(-span_W[0], -span_W[1], 0) / x;
  const Vec<3> away = std::sin(contact.wrap) * outwards + Vec<3>(0, 0, std::cos(contact.wrap));
  return {contact, outwards, exit[0] * outwards + Vec<3>(0, 0, exit[1]), -away,
          radius * contact.wrap + contact.free_length};
}

Eigen::Vector3d PlatformBox(const CdprDescription& robot) {
  Vec<3> half = Vec<3>::Constant(kPlatformThickness / 2);
  for (const CableDescription& cable : robot.cables) half = half.cwiseMax(cable.attachment_B.cwiseAbs());
  return half;
}

}  // namespace tenon
