#include <tenon/plants/cdpr/elastic_catenary.h>
#include <tenon/systems/analysis/internal/small_matrices.h>
#include <tenon/systems/framework/types/internal/held_exceptions.h>

#include <fmt/format.h>

#include <algorithm>

namespace tenon {
namespace {

constexpr int kMostIterations = 200;
constexpr double kTolerance = 2e-14;  // tolerance of the ends' distance, relative to length and distance
constexpr double kLeastHorizontal = 1e-16;  // H over the cable's weight, below which a slack cable is folded

/// The shape of a cable under the forces (H, V_m).
struct Hanging {
  double tension_start, tension_end;
  double slope;    // (T_e - T_s) / (w L), the mean of V/T
  double inverse;  // the mean of 1/T [1/N]
  Eigen::Vector2d span;

  Hanging(double L, double w, double EA, double H, double V) {
    const double half = w * L / 2;
    tension_start = std::hypot(H, V - half);
    tension_end = std::hypot(H, V + half);
    slope = 2 * V / (tension_start + tension_end);
    // Evaluates asinh(V_e/H) - asinh(V_s/H) = log((V_e + T_e) / (V_s + T_s)) from the lower end.
    const double v = slope >= 0 ? V - half : -V - half;
    const double t = slope >= 0 ? tension_start : tension_end;
    const double lower = v >= 0 ? v + t : H * H / (t - v);
    inverse = std::log1p(w * L * (1 + std::abs(slope)) / lower) / (w * L);
    span = L * Eigen::Vector2d(H / EA + H * inverse, V / EA + slope);
  }

  /// d span / d(H, V).
  Eigen::Matrix2d Compliance(double L, double EA, double H, double V) const {
    const double product = tension_start * tension_end;
    const double zz = ((tension_start + tension_end) / 2 - V * slope) / product;  // mean of H^2/T^3
    const double xz = -H * slope / product;                                       // mean of -H V/T^3
    const double xx = std::max(0.0, inverse - zz);                                // mean of V^2/T^3
    Eigen::Matrix2d compliance;
    compliance << 1 / EA + xx, xz, xz, 1 / EA + zz;
    return L * compliance;
  }
};

/// Initial forces: those of the straight cable if it is taut, else those of a parabola with the cable's
/// length (Jayaraman and Knudson, A curved element for the analysis of cable structures, Computers &
/// Structures 14, 1981), and near the transition those of the tension (EA (w L)^2 / 24)^(1/3).
Eigen::Vector2d Guess(double L, double w, double EA, double x, double z) {
  const internal::HeldExceptions held;  // a vertical cable divides by x = 0
  const double distance = std::hypot(x, z);
  const double between = std::cbrt(EA * w * w * L * L / 24);
  const double strained = EA * (distance / L - 1);
  if (strained >= between) return strained / distance * Eigen::Vector2d(x, z);
  const double slack = (L * L - z * z) / (x * x) - 1;
  const double lambda = slack > 0 ? std::sqrt(3 * slack) : 0;
  const double hanging = w * x / (2 * lambda);
  if (!(hanging < between)) return between / distance * Eigen::Vector2d(x, z);
  return {hanging, w * z / (2 * std::tanh(lambda))};
}

}  // namespace

Vec<2> ElasticCatenary::PointAt(double s) const {
  if (!(s > 0)) return Vec<2>::Zero();
  return Hanging(s, weight, axial_stiffness, horizontal, vertical + weight * (s - rest_length) / 2).span;
}

ElasticCatenary HangCatenary(double rest_length, double weight, double axial_stiffness, double x, double z,
                             const ElasticCatenary* near) {
  const double L = rest_length, w = weight, EA = axial_stiffness;
  const double distance = std::hypot(x, z);
  if (!(L > 0 && w > 0 && EA > 0 && x >= 0 && std::isfinite(L + w + EA + distance)))
    throw RunError(
        fmt::format("a cable of {} m, {} N/m and EA = {} N cannot be hung from (0, 0) to ({}, {}) m: give "
                    "finite numbers, the first three positive, the ends' horizontal distance not negative",
                    L, w, EA, x, z));
  const double least = kLeastHorizontal * w * L;
  const Eigen::Vector2d target(x, z);
  Eigen::Vector2d force =
      near == nullptr ? Guess(L, w, EA, x, z) : Eigen::Vector2d(near->horizontal, near->vertical);
  force[0] = std::max(force[0], least);
  Hanging hanging(L, w, EA, force[0], force[1]);
  Eigen::Vector2d missing = target - hanging.span;
  int iterations = 0;
  while (!(missing.norm() <= kTolerance * (L + distance))) {
    if (++iterations > kMostIterations)
      throw RunError(fmt::format(
          "the catenary of {} m, {} N/m and EA = {} N from (0, 0) to ({}, {}) m was not found: its ends are "
          "still {:.3g} m off after {} iterations",
          L, w, EA, x, z, missing.norm(), kMostIterations));
    const Eigen::Vector2d step =
        internal::Inverse<2>(hanging.Compliance(L, EA, force[0], force[1])) * missing;
    const double slope = step.dot(missing);
    for (double part = 1;; part /= 2) {
      Eigen::Vector2d next = force + part * step;
      next[0] = std::max({next[0], 0.1 * force[0], least});
      const Hanging tried(L, w, EA, next[0], next[1]);
      const Eigen::Vector2d left = target - tried.span;
      // Limits the overshoot beyond the minimum to the distance before it.
      if (step.dot(left) >= -slope / 2 || part < 1e-3) {
        force = next;
        hanging = tried;
        missing = left;
        break;
      }
    }
  }

  ElasticCatenary out{.rest_length = L, .weight = w, .axial_stiffness = EA};
  const double H = out.horizontal = force[0], V = out.vertical = force[1];
  out.tension_start = hanging.tension_start;
  out.tension_end = hanging.tension_end;
  const double tension =
      (V * hanging.slope + (out.tension_start + out.tension_end) / 2 + H * H * hanging.inverse) / 2;
  const double square = H * H + V * V + w * w * L * L / 12;  // the means of T and T^2
  out.length = L * (1 + tension / EA);
  out.elastic_energy = L * square / (2 * EA);
  out.potential_energy = force.dot(hanging.span) - L * (square / EA + tension);
  out.stiffness = internal::Inverse<2>(hanging.Compliance(L, EA, H, V));
  out.iterations = iterations;
  return out;
}

}  // namespace tenon
