#pragma once

#include <Eigen/Core>

#include <array>
#include <span>

namespace tenon {

/// Convex polygon in the plane that bounds the ZMP, as inequalities a x + b y + c >= 0 of its edges, with the
/// inward unit normal (a, b) and c in metres.
///
/// The polygon is the convex hull of the stance feet with each edge moved inwards by `margin`. Feet in a line
/// span no area: the line is widened by `half_width` to each side into a rectangle, whose ends are moved
/// inwards by the margin. A single foot is treated as a line of length 0, widened in both directions. If the
/// margin is too large the polygon is empty and Depth is negative everywhere.
class SupportPolygon {
 public:
  static constexpr int kMaxFeet = 4;
  struct Edge {
    double a = 1, b = 0;  ///< [1]
    double c = 0;         ///< [m]
  };

  SupportPolygon() = default;  ///< no edges: the whole plane
  /// Polygon of one to four feet [m]. Throws Error for any other number.
  SupportPolygon(std::span<const Eigen::Vector2d> feet, double half_width, double margin);

  std::span<const Edge> edges() const { return {edges_.data(), static_cast<std::size_t>(num_edges_)}; }
  /// Distance of a point from the nearest edge, the minimum of a x + b y + c [m]; negative outside.
  double Depth(const Eigen::Vector2d& point) const;

 private:
  bool AddLine(std::span<const Eigen::Vector2d> feet, double half_width, double margin);
  void Add(const Eigen::Vector2d& normal, const Eigen::Vector2d& point, double inwards);

  int num_edges_ = 0;
  std::array<Edge, kMaxFeet> edges_;
};

}  // namespace tenon
