#include <tenon/plants/legged/ropes.h>

#include <Eigen/Geometry>

namespace tenon {

void Ropes::CalcTension(const CableVector& command, CableVector* tension) const {
  CheckNumCables(static_cast<int>(params.ropes.size()), command.size(), "Ropes");
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    (*tension)[k] = std::clamp(command[k], 0.0, params.ropes[i].tension_max);
  }
}

ExternalForce Ropes::CalcForce(const LeggedState& robot, const CableVector& tension) const {
  ExternalForce sum;
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const RopeLine line = LineOf(params.ropes[i], robot);
    const Vec<3> pull = tension[static_cast<Eigen::Index>(i)] * line.direction_W;
    sum.force_W += pull;
    sum.torque_W += line.arm_W.cross(pull);
  }
  return sum;
}

Geometry Ropes::MakeGeometry() const {
  constexpr double kDrawnRadius = 0.006;  // [m]
  Geometry lines;
  for (const Rope& rope : params.ropes)
    lines.push_back(Shape::Segment(ShapeRole::kLine, rope.name, kDrawnRadius, "N"));
  return lines;
}

void Ropes::CalcGeometry(const LeggedState& robot, const CableVector& tension, Geometry* geometry) const {
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const RopeLine line = LineOf(params.ropes[i], robot);
    Shape& shape = (*geometry)[i];
    shape.p_W = robot.p_WB + line.arm_W;
    shape.vector_W = line.length * line.direction_W;
    shape.value = tension[static_cast<Eigen::Index>(i)];
  }
}

}  // namespace tenon
