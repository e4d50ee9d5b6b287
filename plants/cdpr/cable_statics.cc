#include <tenon/plants/cdpr/cable_statics.h>
#include <tenon/plants/model/swivel_pulley.h>

#include <fmt/format.h>

namespace tenon {
namespace {

constexpr int kMostTurns = 100;
constexpr double kWrapTolerance =
    1e-12;  // tolerance of wrap angles [rad], and of lengths relative to that of the cable

/// Course of the cable from the winch: over a pulley, or through the anchor.
struct Lead {
  double radius = 0;
  double x = 0, z = 0;  // from anchor to attachment, in the pulley's plane [m]
};

/// The part of the cable on the pulley, from the anchor over a wrap b to the exit with the tension T_e,
/// without friction. With (1 + T/EA) dT = w dz along it,
///
///     T_0 + T_0^2/(2 EA) = T_e + T_e^2/(2 EA) - w r sin b,   T = T_0 + w r sin(angle) / (1 + T_0/EA) + ...,
///
/// to first order in w r / EA; the second order is about 1e-12.
struct Wrap {
  double tension;           // T_0 [N]
  double rest_length;       // [m]
  double elastic_energy;    // [J]
  double potential_energy;  // above the anchor [J]

  Wrap(double radius, double wrap, double tension_end, double weight, double EA) {
    const double at_anchor =
        tension_end + tension_end * tension_end / (2 * EA) - weight * radius * std::sin(wrap);
    const double stretch = std::sqrt(1 + 2 * at_anchor / EA);
    const double moment = weight * radius * radius * (1 - std::cos(wrap)) / stretch;
    tension = EA * (stretch - 1);
    rest_length = radius * wrap / stretch - moment / (EA * stretch * stretch);
    elastic_energy = tension * tension / (2 * EA) * rest_length + tension * moment / (EA * stretch);
    potential_energy = moment;
  }
};

/// Computes the shape of a cable from the attachment to the pulley, which it leaves tangentially, or to the
/// anchor if the radius is 0.
void HangOnPulley(const CdprDescription& robot, int index, const Lead& lead, double rest_length,
                  double weight, CableStatics* out) {
  const double EA = robot.cable.axial_stiffness;
  double wrap = LeaveStraight(lead.radius, lead.x, lead.z).wrap;
  double wound = lead.radius * wrap;  // rest length on the pulley [m]
  const ElasticCatenary* near = nullptr;
  for (int turn = 0;; ++turn) {
    if (turn == kMostTurns)
      throw RunError(
          fmt::format("cable {} of {} m finds no rest on its pulley of {} m radius; give a smaller "
                      "pulley_radius_m",
                      index, rest_length, lead.radius));
    const Vec<2> exit = ExitPoint(lead.radius, wrap);
    const double side = lead.x < exit[0] ? -1 : 1;
    if (rest_length <= wound)
      throw RunError(
          fmt::format("cable {} is reeled in up to its pulley (rest length {} m); command less "
                      "tension or move the platform away from the anchor",
                      index, rest_length));
    out->catenary =
        HangCatenary(rest_length - wound, weight, EA, side * (lead.x - exit[0]), exit[1] - lead.z, near);
    near = &out->catenary;
    const ElasticCatenary& hangs = out->catenary;
    const double leaves = WrapOf(side * hangs.horizontal, -hangs.vertical_end());
    const Wrap wrapped(lead.radius, leaves, hangs.tension_end, weight, EA);
    const bool settled =
        lead.radius == 0 || (std::abs(leaves - wrap) <= kWrapTolerance &&
                             std::abs(wrapped.rest_length - wound) <= kWrapTolerance * rest_length);
    wrap = leaves;
    wound = wrapped.rest_length;
    if (!settled) continue;

    const Vec<3> up(0, 0, 1);
    out->toward_W = -side * out->plane_W;
    out->direction_W = (hangs.horizontal * out->toward_W + hangs.vertical_start() * up) / hangs.tension_start;
    out->length = hangs.length + lead.radius * wrap;
    out->tension = wrapped.tension;
    out->tension_loss = out->tension - hangs.tension_start;
    const Vec<2> tangent = Vec<2>(hangs.horizontal, hangs.vertical_start()) / hangs.tension_start;
    out->elastic_length = EA / tangent.dot(hangs.stiffness * tangent) + wound;
    out->elastic_energy = hangs.elastic_energy + wrapped.elastic_energy;
    out->potential_energy =
        hangs.potential_energy + wrapped.potential_energy +
        weight * (hangs.rest_length * (exit[1] + lead.z) / 2 + rest_length * out->anchor_W[2]);
    out->exit_W += exit[0] * out->plane_W + exit[1] * up;
    return;
  }
}

}  // namespace

CableStatics CalcCableStatics(const CdprDescription& robot, int index, const Vec<3>& span_W,
                              double rest_length, double gravity, const Eigen::Matrix3d& R_WB) {
  const double EA = robot.cable.axial_stiffness;
  const double weight = robot.cable.mass_per_length * gravity;
  const double chord = span_W.norm();
  if (chord == 0)
    throw RunError(
        fmt::format("cable {} has no length and so no direction: its attachment is at its anchor", index));
  if (rest_length <= 0)
    throw RunError(fmt::format(
        "cable {} is reeled in completely (rest length {} m); command less tension or move the platform away "
        "from the anchor",
        index, rest_length));

  CableStatics out;
  out.anchor_W = out.exit_W = robot.cables[index].anchor_W;
  // Seen from the platform, the anchor is the end of a cable over a pulley at the attachment.
  const bool carried = robot.carries_pulley(index);
  const Vec<3> to_swivel = carried ? Vec<3>(R_WB.transpose() * -span_W) : span_W;
  Lead lead{robot.pulley_radius(index), std::hypot(to_swivel[0], to_swivel[1]), -to_swivel[2]};
  if (lead.x > 0) out.plane_W = Vec<3>(-to_swivel[0], -to_swivel[1], 0) / lead.x;
  if (carried) out.plane_W = (R_WB * out.plane_W).eval();
  const double from_center = std::hypot(lead.x - lead.radius, lead.z);
  if (lead.radius > 0 && !(from_center > lead.radius && lead.x > 0))
    throw RunError(
        fmt::format("cable {} ends {:.4g} m beside the swivel axis of its pulley and {:.4g} m away from the "
                    "pulley's centre, whose radius is {} m; keep the attachment off both, or give a smaller "
                    "pulley_radius_m",
                    index, lead.x, from_center, lead.radius));
  if (weight > 0) {
    HangOnPulley(robot, index, lead, rest_length, weight, &out);
    return out;
  }

  out.direction_W = span_W / chord;
  out.length = chord;
  if (lead.radius > 0) {
    const StraightLead straight = LeadStraight(lead.radius, to_swivel);
    out.direction_W = straight.direction_W;
    out.length = straight.length;
    if (carried) {
      out.direction_W = R_WB * -straight.direction_W;
      out.lead_W = R_WB * straight.exit_W;
    } else {
      out.exit_W += straight.exit_W;
    }
  }
  out.elastic_length = rest_length;
  if (out.length > rest_length) {
    out.tension = EA / rest_length * (out.length - rest_length);
    out.elastic_energy = EA / (2 * rest_length) * (out.length - rest_length) * (out.length - rest_length);
  }
  return out;
}

double CalcRestLength(const CdprDescription& robot, int index, const Vec<3>& span_W, double tension,
                      double gravity, const Eigen::Matrix3d& R_WB) {
  const double weight = robot.cable.mass_per_length * gravity;
  CdprDescription weightless = robot;
  weightless.cable.mass_per_length = 0;
  const double length = CalcCableStatics(weightless, index, span_W, span_W.norm(), gravity, R_WB).length;
  const double EA = robot.cable.axial_stiffness;
  if (!(weight > 0)) return length / (1 + tension / EA);

  // At this length the tension is too high at both ends. It decreases with the length down to its minimum.
  const double shortest = length / (1 + (tension + weight * length) / EA);
  const auto tension_of = [&](double rest_length) {
    return CalcCableStatics(robot, index, span_W, rest_length, gravity).tension;
  };
  double less = shortest, more = shortest, before = tension_of(shortest);
  for (double step = 1e-9 * shortest;; step *= 1.5) {
    more = less + step;
    const double now = tension_of(more);
    if (now <= tension) break;
    if (now > before)
      throw RunError(fmt::format(
          "cable {} is to pull with {} N, but it pulls with {:.3g} N or more by its own weight; ask for more "
          "tension or give less mass_kg_per_m",
          index, tension, before));
    before = now;
    less = more;
  }
  for (int i = 0; i < 100 && less < more; ++i) {
    const double middle = less + (more - less) / 2;
    if (middle == less || middle == more) break;
    (tension_of(middle) > tension ? less : more) = middle;
  }
  return more;
}

}  // namespace tenon
