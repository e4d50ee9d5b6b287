#include <tenon/controllers/legged/planning/support_polygon.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

#include <algorithm>
#include <limits>

namespace tenon {
namespace {

constexpr double kSamePoint = 1e-6;  // tolerance of coincident feet and of feet in a line [m]

Eigen::Vector2d TurnedLeft(const Eigen::Vector2d& v) {
  return {-v[1], v[0]};
}

}  // namespace

SupportPolygon::SupportPolygon(std::span<const Eigen::Vector2d> feet, double half_width, double margin) {
  if (feet.empty() || feet.size() > kMaxFeet)
    throw Error(fmt::format("a support polygon of {} feet: give one to {} feet", feet.size(), kMaxFeet));
  if (AddLine(feet, half_width, margin)) return;
  // Counterclockwise around the hull; of several feet in a line the farthest is next.
  const auto is_before = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
  };
  const auto first = static_cast<std::size_t>(std::ranges::min_element(feet, is_before) - feet.begin());
  std::array<std::size_t, kMaxFeet> next;
  next.fill(kMaxFeet);
  for (std::size_t i = first, steps = 0; steps < feet.size(); ++steps) {
    std::size_t to = i;
    Eigen::Vector2d way = Eigen::Vector2d::Zero();
    for (std::size_t j = 0; j < feet.size(); ++j) {
      const Eigen::Vector2d other = feet[j] - feet[i];
      if (other.norm() < kSamePoint) continue;
      const double left = TurnedLeft(way.normalized()).dot(other);
      if (left > 0 || (left == 0 && other.norm() <= way.norm())) continue;
      to = j;
      way = other;
    }
    next[i] = to;
    i = to;
    if ((feet[i] - feet[first]).norm() < kSamePoint) break;
  }
  for (std::size_t i = 0; i < feet.size(); ++i)
    if (next[i] < kMaxFeet) Add(TurnedLeft((feet[next[i]] - feet[i]).normalized()), feet[i], margin);
}

/// Adds the rectangle if all feet are in a line or coincide; returns false otherwise.
bool SupportPolygon::AddLine(std::span<const Eigen::Vector2d> feet, double half_width, double margin) {
  Eigen::Vector2d begin = feet[0], end = feet[0];  // the two feet that are farthest apart
  for (std::size_t i = 0; i < feet.size(); ++i) {
    for (std::size_t j = i + 1; j < feet.size(); ++j) {
      if ((feet[j] - feet[i]).norm() <= (end - begin).norm()) continue;
      begin = feet[i];
      end = feet[j];
    }
  }
  const double length = (end - begin).norm();
  const bool is_point = length < kSamePoint;
  const Eigen::Vector2d along = is_point ? Eigen::Vector2d(1, 0) : Eigen::Vector2d((end - begin) / length);
  const Eigen::Vector2d normal = TurnedLeft(along);
  for (const Eigen::Vector2d& foot : feet)
    if (std::abs(normal.dot(foot - begin)) > kSamePoint) return false;
  Add(normal, begin, -half_width);
  Add(-normal, begin, -half_width);
  Add(along, begin, is_point ? -half_width : margin);
  Add(-along, end, is_point ? -half_width : margin);
  return true;
}

void SupportPolygon::Add(const Eigen::Vector2d& normal, const Eigen::Vector2d& point, double inwards) {
  edges_[num_edges_++] = {normal[0], normal[1], -normal.dot(point) - inwards};
}

double SupportPolygon::Depth(const Eigen::Vector2d& point) const {
  double depth = std::numeric_limits<double>::infinity();
  for (const Edge& e : edges()) depth = std::min(depth, e.a * point[0] + e.b * point[1] + e.c);
  return depth;
}

}  // namespace tenon
