#include <tenon/diagrams/evaluation/walk_view.h>

namespace tenon {

Geometry WalkView::MakeShapes(const QuadrupedDescription& robot) {
  const double scale =
      2 * robot.StanceHeight() / (kGravity * robot.mass());  // the weight is twice the robot's height
  Geometry shapes{Shape::Trace(ShapeRole::kReference, "reference of the CoM"),
                  Shape::Arrow(ShapeRole::kEstimate, "estimated force on the CoM", scale)};
  for (const char* leg : kLegNames)
    shapes.push_back(Shape::Arrow(ShapeRole::kEstimate, "estimated force on " + std::string(leg), scale));
  return shapes;
}

void WalkView::CalcGeometry(const LeggedState& state, const BodyReference& body, const WrenchEstimate& wrench,
                            const LegForceEstimate& leg_forces, Geometry* geometry) const {
  Geometry& shapes = *geometry;
  shapes[0].p_W = body.com_W;
  shapes[1].p_W = body.com_W;
  shapes[1].vector_W = wrench.force_W;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    Shape& arrow = shapes[2 + static_cast<std::size_t>(leg)];
    arrow.p_W = state.p_WB + state.R_WB() * params.robot.FootPosition(leg, state.q);
    arrow.vector_W = leg_forces.foot_force[leg];
  }
}

}  // namespace tenon
