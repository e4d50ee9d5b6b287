#pragma once

#include <Eigen/Core>

#include <array>
#include <span>

namespace tenon {

/// The convex polygon in the plane in which the ZMP is to stay, as inequalities a x + b y + c >= 0 of its
/// edges, (a, b) the unit normal that points inwards, c in metres.
///
/// It is the convex hull of the stance feet with each edge moved inwards by `margin`. Two feet, or several in
/// line, span no area: the line is widened to a rectangle that reaches `half_width` to each side; its ends
/// are moved inwards by the margin. One foot is such a line of no length, widened in both directions. A
/// margin that is too large leaves an empty polygon: Depth is negative everywhere.
class SupportPolygon {
 public:
  static constexpr int kMaxFeet = 4;
  struct Edge {
    double a = 1, b = 0;  ///< [1]
    double c = 0;         ///< [m]
  };

  SupportPolygon() = default;  ///< without edges: the whole plane
  /// Of one to four feet [m]. Throws Error for other numbers of them.
  SupportPolygon(std::span<const Eigen::Vector2d> feet, double half_width, double margin);

  std::span<const Edge> edges() const { return {edges_.data(), static_cast<std::size_t>(num_edges_)}; }
  /// The least a x + b y + c over the edges [m]: how far inside a point is; negative outside.
  double Depth(const Eigen::Vector2d& point) const;

 private:
  bool AddLine(std::span<const Eigen::Vector2d> feet, double half_width, double margin);
  void Add(const Eigen::Vector2d& normal, const Eigen::Vector2d& point, double inwards);

  int num_edges_ = 0;
  std::array<Edge, kMaxFeet> edges_;
};

}  // namespace tenon
