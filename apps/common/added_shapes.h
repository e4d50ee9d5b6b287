#pragma once

#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/geometry.h>

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace tenon::apps {

/// The surfaces of bodies that were added to a robot (ExtendQuadruped, ExtendCdpr), from a log of the plant's
/// `geometry`. A surface is a set of points with a radius: corners of boxes and meshes, ends of capsules and
/// rods, edges of cylinders. Fixtures, arrows and traces are left out.
class AddedShapes {
 public:
  AddedShapes() = default;
  /// `shapes` with their constant members; `first` is the index of the first one in the plant's geometry.
  AddedShapes(const Geometry& shapes, std::size_t first);
  /// The shapes that were added to the plant that stands in the diagram, behind the `first` ones of its
  /// geometry; none for a plant of another class.
  template <class Plant>
  static AddedShapes Of(const Plant& plant, std::size_t first) {
    const Plant& shipped = CurrentAs(plant);
    return CurrentBlock(plant) == &shipped ? AddedShapes(shipped.additions.shapes, first) : AddedShapes();
  }

  bool empty() const { return surfaces_.empty(); }
  void Begin(const std::vector<std::string>& names, const OutputPort<Geometry>& geometry);
  using Visitor = std::function<void(const std::string& name, const Vec<3>& p_W, double radius)>;
  /// Visits all points, by the name of their shape.
  void Visit(std::span<const double> row, const Visitor& visit) const;

 private:
  struct Surface {
    std::string name;
    std::size_t shape;
    bool segment;
    double radius;                                      // [m]
    std::vector<Vec<3>> points;                         // in the shape's frame [m]
    std::vector<std::size_t> p_W{}, q_W{}, vector_W{};  // columns
  };
  std::vector<Surface> surfaces_;
};

}  // namespace tenon::apps
