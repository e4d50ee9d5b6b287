#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/signal.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tenon {

enum class ShapeKind {
  kBox,       ///< about p_W, edges along its frame; size: the three edges [m]
  kSphere,    ///< about p_W; size: radius [m]
  kCylinder,  ///< about p_W, along its frame's z; size: radius, length [m]
  kCapsule,   ///< the same with round ends; length is that of the cylinder between them
  kSegment,   ///< a straight rod from p_W to p_W + vector_W [m]; size: radius [m]
  kArrow,     ///< from p_W along scale * vector_W, for forces and velocities
  kMesh,      ///< triangles, given in its frame
  kTrace,     ///< the path that p_W takes in the whole run; size: radius of a ball at p_W, or 0 [m]
};
constexpr auto EnumNames(ShapeKind) {
  return std::array{Named{ShapeKind::kBox, "box"},           Named{ShapeKind::kSphere, "sphere"},
                    Named{ShapeKind::kCylinder, "cylinder"}, Named{ShapeKind::kCapsule, "capsule"},
                    Named{ShapeKind::kSegment, "segment"},   Named{ShapeKind::kArrow, "arrow"},
                    Named{ShapeKind::kMesh, "mesh"},         Named{ShapeKind::kTrace, "trace"}};
}

/// What a shape stands for: decides its colour, and can be shown and hidden together.
enum class ShapeRole {
  kBody,   ///< of what moves by the diagram: a replay follows it
  kLine,   ///< what it hangs on or pulls at
  kLoad,   ///< what it carries
  kOther,  ///< what moves beside it
  kGround,
  kFixture,  ///< what stands around
  kForce,
  kDisturbance,
  kEstimate,
  kReference
};
constexpr auto EnumNames(ShapeRole) {
  return std::array{Named{ShapeRole::kBody, "bodies"},        Named{ShapeRole::kLine, "lines"},
                    Named{ShapeRole::kLoad, "loads"},         Named{ShapeRole::kOther, "others"},
                    Named{ShapeRole::kGround, "ground"},      Named{ShapeRole::kFixture, "fixtures"},
                    Named{ShapeRole::kForce, "forces"},       Named{ShapeRole::kDisturbance, "disturbances"},
                    Named{ShapeRole::kEstimate, "estimates"}, Named{ShapeRole::kReference, "reference"}};
}

/// A surface of triangles that share their corners.
struct TriangleMesh {
  std::vector<std::array<float, 3>> corners;            ///< [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of corners, counterclockwise from outside
};

/// One thing to look at. What stays the same during a run is set once, in the initial value of the port that
/// puts it out; what moves is written at every evaluation, and that alone is logged.
struct Shape {
  ShapeKind kind = ShapeKind::kSphere;
  ShapeRole role = ShapeRole::kBody;
  std::string name{};
  Vec<3> size = Vec<3>::Zero();  ///< see ShapeKind [m]
  double scale = 1;              ///< of an arrow: its length [m] per unit of vector_W, say m/N
  std::string unit{};            ///< of `value`; if given, the value decides the colour

  Vec<3> p_W = Vec<3>::Zero();       ///< [m]
  Vec<4> q_W{1, 0, 0, 0};            ///< attitude (w, x, y, z)
  Vec<3> vector_W = Vec<3>::Zero();  ///< of a segment [m], of an arrow in its own unit
  double value = 0;
  bool visible = true;
  std::shared_ptr<const TriangleMesh> mesh{};  ///< of a kMesh

  static Shape Box(ShapeRole role, std::string name, const Vec<3>& edges) {
    return {ShapeKind::kBox, role, std::move(name), edges};
  }
  static Shape Sphere(ShapeRole role, std::string name, double radius) {
    return {ShapeKind::kSphere, role, std::move(name), {radius, 0, 0}};
  }
  static Shape Cylinder(ShapeRole role, std::string name, double radius, double length) {
    return {ShapeKind::kCylinder, role, std::move(name), {radius, length, 0}};
  }
  static Shape Capsule(ShapeRole role, std::string name, double radius, double length) {
    return {ShapeKind::kCapsule, role, std::move(name), {radius, length, 0}};
  }
  static Shape Segment(ShapeRole role, std::string name, double radius, std::string unit = "") {
    return {ShapeKind::kSegment, role, std::move(name), {radius, 0, 0}, 1, std::move(unit)};
  }
  static Shape Arrow(ShapeRole role, std::string name, double scale) {
    return {ShapeKind::kArrow, role, std::move(name), Vec<3>::Zero(), scale};
  }
  static Shape Mesh(ShapeRole role, std::string name, std::shared_ptr<const TriangleMesh> mesh) {
    Shape shape{ShapeKind::kMesh, role, std::move(name)};
    shape.mesh = std::move(mesh);
    return shape;
  }
  static Shape Trace(ShapeRole role, std::string name, double ball_radius = 0) {
    return {ShapeKind::kTrace, role, std::move(name), {ball_radius, 0, 0}};
  }

  /// What moves.
  static FieldList Fields() {
    return {{"p_W", &Shape::p_W, "m"},  {"q_W", &Shape::q_W, "", "w,x,y,z"}, {"vector_W", &Shape::vector_W},
            {"value", &Shape::value},   {"visible", &Shape::visible},        Undescribed(&Shape::kind),
            Undescribed(&Shape::role),  Undescribed(&Shape::name),           Undescribed(&Shape::size),
            Undescribed(&Shape::scale), Undescribed(&Shape::unit),           Undescribed(&Shape::mesh)};
  }
};

/// What a block looks like: a signal like any other, which a plant, a reference or an observer puts out and a
/// replay draws, so that whatever draws knows nothing of what it draws. The number of shapes is that of the
/// port's initial value and stays. W is the world, z up, SI units.
///
///     OutputPort<Geometry> geometry{this, {"geometry"},
///                                   {Shape::Box(ShapeRole::kBody, "cart", {.3, .2, .1})},
///                                   Uses(x), &Cart::CalcGeometry};
///     void CalcGeometry(const Vec<2>& x, Geometry* out) const { (*out)[0].p_W = {x[0], 0, 0.05}; }
using Geometry = std::vector<Shape>;

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::Geometry);
