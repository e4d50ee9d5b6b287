#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

enum class ShapeKind {
  kBox,       ///< centred at p_W, edges along its axes; size: the three edges [m]
  kSphere,    ///< centred at p_W; size: radius [m]
  kCylinder,  ///< centred at p_W, along its z axis; size: radius, length [m]
  kCapsule,   ///< like a cylinder with round ends; length is that of the cylindrical part
  kSegment,   ///< a straight rod from p_W to p_W + vector_W [m]; size: radius [m]
  kArrow,     ///< arrow from p_W along scale * vector_W, for forces and velocities
  kMesh,      ///< triangles, in coordinates of its frame
  kTrace,     ///< path of p_W during the whole run; size: radius of a ball at p_W, or 0 [m]
};

/// Category of a shape, which sets its colour; shapes of a category can be shown and hidden together.
enum class ShapeRole {
  kBody,   ///< bodies moved by the diagram; a replay follows them with its camera
  kLine,   ///< cables, ropes and leashes
  kLoad,   ///< payloads
  kOther,  ///< other moving bodies
  kGround,
  kFixture,  ///< stationary objects
  kForce,
  kDisturbance,
  kEstimate,
  kReference,
  kCollision  ///< shapes of contact that differ from the drawn ones; a page hides them at first
};
constexpr auto EnumNames(ShapeRole) {
  return std::array{Named{ShapeRole::kBody, "bodies"},
                    Named{ShapeRole::kLine, "lines"},
                    Named{ShapeRole::kLoad, "loads"},
                    Named{ShapeRole::kOther, "others"},
                    Named{ShapeRole::kGround, "ground"},
                    Named{ShapeRole::kFixture, "fixtures"},
                    Named{ShapeRole::kForce, "forces"},
                    Named{ShapeRole::kDisturbance, "disturbances"},
                    Named{ShapeRole::kEstimate, "estimates"},
                    Named{ShapeRole::kReference, "reference"},
                    Named{ShapeRole::kCollision, "collision shapes"}};
}

/// A surface of triangles with shared corners.
struct TriangleMesh {
  std::vector<std::array<float, 3>> corners;            ///< [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of corners, counterclockwise from outside
  /// Red, green and blue of each corner, and 255, or 0 for the colour of the role; empty: all have that
  /// colour.
  std::vector<std::array<std::uint8_t, 4>> colours{};
};

/// One object to be drawn. The constant members are set once, in the initial value of the output port; the
/// members in Fields() are written at every evaluation, and only these are logged.
struct Shape {
  ShapeKind kind = ShapeKind::kSphere;
  ShapeRole role = ShapeRole::kBody;
  std::string name{};
  Vec<3> size = Vec<3>::Zero();  ///< see ShapeKind [m]
  double scale = 1;              ///< length of an arrow [m] per unit of vector_W, for example in m/N
  std::string unit{};            ///< unit of `value`; if not empty, the value sets the colour

  Vec<3> p_W = Vec<3>::Zero();       ///< [m]
  Vec<4> q_W{1, 0, 0, 0};            ///< attitude (w, x, y, z)
  Vec<3> vector_W = Vec<3>::Zero();  ///< vector of a segment [m], or of an arrow in its own unit
  double value = 0;
  bool visible = true;
  std::shared_ptr<const TriangleMesh> mesh{};  ///< triangles of a kMesh

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

  /// The members that change during a run.
  static FieldList Fields() {
    return {{"p_W", &Shape::p_W, "m"},  {"q_W", &Shape::q_W, "", "w,x,y,z"}, {"vector_W", &Shape::vector_W},
            {"value", &Shape::value},   {"visible", &Shape::visible},        Undescribed(&Shape::kind),
            Undescribed(&Shape::role),  Undescribed(&Shape::name),           Undescribed(&Shape::size),
            Undescribed(&Shape::scale), Undescribed(&Shape::unit),           Undescribed(&Shape::mesh)};
  }
};

/// The appearance of a block as a signal: a plant, a reference or an observer outputs it and a replay draws
/// it, without knowing the block. The number of shapes is set by the port's initial value. W is the world
/// frame, z up, SI units.
///
///     OutputPort<Geometry> geometry{this, {"geometry"},
///                                   {Shape::Box(ShapeRole::kBody, "cart", {.3, .2, .1})},
///                                   Uses(x), &Cart::CalcGeometry};
///     void CalcGeometry(const Vec<2>& x, Geometry* out) const { (*out)[0].p_W = {x[0], 0, 0.05}; }
using Geometry = std::vector<Shape>;

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::Geometry);
