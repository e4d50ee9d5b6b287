#include <tenon/plants/cdpr/cdpr_geometry.h>

#include <string>

namespace tenon {
namespace {

constexpr double kCableRadius = 0.008;       // [m]
constexpr double kPlatformThickness = 0.04;  // [m], at least, if all attachments lie in one plane
constexpr double kForceScale = 0.01;         // [m/N]
constexpr double kPayloadRadius = 0.05;      // [m]

// The order of the shapes: these, then one cable, one anchor and one post per cable.
enum Index { kPlatform, kPath, kPayloadBall, kForce, kFirstCable };

}  // namespace

Geometry MakeCdprGeometry(const CdprDescription& robot) {
  Vec<3> half = Vec<3>::Constant(kPlatformThickness / 2);
  for (const CableDescription& cable : robot.cables) half = half.cwiseMax(cable.attachment_B.cwiseAbs());

  Geometry shapes(kFirstCable);
  shapes[kPlatform] = Shape::Box(ShapeRole::kBody, "platform", 2 * half);
  shapes[kPath] = Shape::Trace(ShapeRole::kBody, "path of the platform");
  shapes[kPayloadBall] = Shape::Sphere(ShapeRole::kLoad, "payload", kPayloadRadius);
  shapes[kForce] = Shape::Arrow(ShapeRole::kDisturbance, "external force", kForceScale);
  for (std::size_t i = 0; i < robot.cables.size(); ++i)
    shapes.push_back(Shape::Segment(ShapeRole::kLine, "cable " + std::to_string(i), kCableRadius, "N"));
  for (std::size_t i = 0; i < robot.cables.size(); ++i) {
    Shape anchor = Shape::Sphere(ShapeRole::kFixture, "anchor " + std::to_string(i), 0.05);
    anchor.p_W = robot.cables[i].anchor_W;
    Shape post = Shape::Segment(ShapeRole::kFixture, "post " + std::to_string(i), 0.025);
    post.p_W = {anchor.p_W[0], anchor.p_W[1], 0};
    post.vector_W = {0, 0, anchor.p_W[2]};
    shapes.push_back(std::move(anchor));
    shapes.push_back(std::move(post));
  }
  return shapes;
}

void MoveCdprGeometry(const CdprDescription& robot, const PlatformState& platform, const CableVector& tension,
                      const Payload& payload, const PlatformWrench& wrench, Geometry* geometry) {
  Geometry& shapes = *geometry;
  const Eigen::Matrix3d R_WB = platform.R_WB();
  shapes[kPlatform].p_W = shapes[kPath].p_W = shapes[kForce].p_W = platform.p_WB;
  shapes[kPlatform].q_W = platform.q_WB.normalized();
  shapes[kForce].vector_W = wrench.force_W;

  Shape& ball = shapes[kPayloadBall];
  ball.visible = payload.mass > 0;
  ball.p_W = platform.p_WB + R_WB * payload.p_B;
  for (std::size_t i = 0; i < robot.cables.size(); ++i) {
    Shape& cable = shapes[kFirstCable + i];
    cable.p_W = platform.p_WB + R_WB * robot.cables[i].attachment_B;
    cable.vector_W = robot.cables[i].anchor_W - cable.p_W;
    cable.value = tension[static_cast<Eigen::Index>(i)];
  }
}

}  // namespace tenon
