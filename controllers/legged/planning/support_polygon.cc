#include <tenon/controllers/legged/planning/support_polygon.h>

#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include <tenon/systems/framework/errors.h>

namespace tenon {
namespace {

constexpr double kSamePoint = 1e-6;  // feet that are closer than this are one; so are lines [m]

Eigen::Vector2d TurnedLeft(const Eigen::Vector2d& v) {
  return {-v[1], v[0]};
}

}  // namespace

SupportPolygon::SupportPolygon(std::span<const Eigen::Vector2d> feet, double half_width, double margin) {
  if (feet.empty() || feet.size() > kMaxFeet) {
    throw Error(fmt::format("a support polygon of {} feet: give one to {}", feet.size(), kMaxFeet));
  }
  // An edge leads from i to j if all feet are to its left, and those upon it between the two.
  for (std::size_t i = 0; i < feet.size(); ++i) {
    for (std::size_t j = 0; j < feet.size(); ++j) {
      const Eigen::Vector2d way = feet[j] - feet[i];
      const double length = way.norm();
      if (length < kSamePoint) continue;
      const Eigen::Vector2d along = way / length, normal = TurnedLeft(along);
      bool is_edge = true, has_area = false;
      for (std::size_t k = 0; k < feet.size() && is_edge; ++k) {
        const Eigen::Vector2d other = feet[k] - feet[i];
        const double left = normal.dot(other), forward = along.dot(other);
        has_area = has_area || left > kSamePoint;
        const bool upon = std::abs(left) <= kSamePoint;
        const bool duplicate =
            (k < i && other.norm() < kSamePoint) || (k < j && (feet[k] - feet[j]).norm() < kSamePoint);
        is_edge = left >= -kSamePoint && !duplicate &&
                  (!upon || (forward >= -kSamePoint && forward <= length + kSamePoint));
      }
      if (!is_edge) continue;
      if (has_area) {
        Add(normal, feet[i], margin);
      } else if (num_edges_ == 0) {  // all in line, and i and j are its ends
        Add(normal, feet[i], -half_width);
        Add(-normal, feet[i], -half_width);
        Add(along, feet[i], margin);
        Add(-along, feet[j], margin);
      }
    }
  }
  if (num_edges_ > 0) return;
  for (const Eigen::Vector2d& normal : {Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}) {
    Add(normal, feet[0], -half_width);
    Add(-normal, feet[0], -half_width);
  }
}

void SupportPolygon::Add(const Eigen::Vector2d& normal, const Eigen::Vector2d& point, double inwards) {
  edges_[static_cast<std::size_t>(num_edges_++)] = {normal[0], normal[1], -normal.dot(point) - inwards};
}

double SupportPolygon::Depth(const Eigen::Vector2d& point) const {
  double depth = std::numeric_limits<double>::infinity();
  for (const Edge& e : edges()) depth = std::min(depth, e.a * point[0] + e.b * point[1] + e.c);
  return depth;
}

}  // namespace tenon
