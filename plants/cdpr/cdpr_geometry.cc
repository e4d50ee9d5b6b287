#include <tenon/plants/cdpr/cdpr_geometry.h>
#include <tenon/plants/signals/quaternion.h>

#include <algorithm>
#include <numbers>

namespace tenon {
namespace {

constexpr double kCableRadius = 0.008, kAnchorRadius = 0.05, kPostRadius = 0.025,
                 kSpringRadius = 0.02;  // up to kSpan [m]
constexpr double kSpan =
    6;  // cables and posts of robots with a larger span are thicker, as seen from farther away [m]
constexpr double kForceScale = 0.01;     // [m/N]
constexpr double kPayloadRadius = 0.05;  // [m]
constexpr double kPulleyWidth = 0.02;    // [m]

constexpr std::size_t kSaggingPieces = 12;

// Order of the shapes: these, then the pieces of each cable, then each pulley, then one anchor and one
// post per cable, then each spring, then the obstacles.
enum Index { kPlatform, kPath, kPayloadBall, kForce, kFirstCable };

std::size_t PiecesPerCable(const CdprDescription& robot) {
  return robot.cable.mass_per_length > 0 ? kSaggingPieces : 1;
}

/// Factor of the thickness of cables, anchors and posts.
double Thickening(const CdprDescription& robot) {
  Vec<3> center = Vec<3>::Zero();
  for (const CableDescription& cable : robot.cables) center += cable.anchor_W / robot.num_cables();
  double span = kSpan;
  for (const CableDescription& cable : robot.cables) span = std::max(span, (cable.anchor_W - center).norm());
  return span / kSpan;
}

/// Places an anchor and the post that follows it, up from the floor.
void PlaceFixture(const Vec<3>& anchor_W, double floor, Shape* anchor) {
  Shape* const post = anchor + 1;
  anchor->p_W = anchor_W;
  post->p_W = {anchor_W[0], anchor_W[1], floor};
  post->vector_W = {0, 0, anchor_W[2] - floor};
}

}  // namespace

Geometry MakeCdprGeometry(const CdprDescription& robot) {
  const double thicker = Thickening(robot);
  Geometry shapes(kFirstCable);
  shapes[kPlatform] = Shape::Box(ShapeRole::kBody, "platform", 2 * PlatformBox(robot));
  shapes[kPath] = Shape::Trace(ShapeRole::kBody, "path of the platform");
  shapes[kPayloadBall] = Shape::Sphere(ShapeRole::kLoad, "payload", kPayloadRadius);
  shapes[kForce] = Shape::Arrow(ShapeRole::kDisturbance, "external force", kForceScale);
  for (std::size_t i = 0; i < robot.cables.size(); ++i)
    for (std::size_t k = 0; k < PiecesPerCable(robot); ++k)
      shapes.push_back(
          Shape::Segment(ShapeRole::kLine, "cable " + std::to_string(i), thicker * kCableRadius, "N"));
  if (robot.has_pulleys())
    for (std::size_t i = 0; i < robot.cables.size(); ++i)
      shapes.push_back(Shape::Cylinder(ShapeRole::kFixture, "pulley " + std::to_string(i),
                                       robot.pulley_radius(i), kPulleyWidth));
  for (std::size_t i = 0; i < robot.cables.size(); ++i) {
    Shape anchor = Shape::Sphere(ShapeRole::kFixture, "anchor " + std::to_string(i), thicker * kAnchorRadius);
    Shape post = Shape::Segment(ShapeRole::kFixture, "post " + std::to_string(i), thicker * kPostRadius);
    shapes.push_back(std::move(anchor));
    shapes.push_back(std::move(post));
    PlaceFixture(robot.cables[i].anchor_W, robot.floor, &shapes[shapes.size() - 2]);
  }
  for (std::size_t i = 0; i < robot.springs.size(); ++i) {
    shapes.push_back(
        Shape::Segment(ShapeRole::kOther, "spring " + std::to_string(i), thicker * kSpringRadius));
    shapes.back().p_W = robot.springs[i].anchor_W;
  }
  for (const ObstacleDescription& obstacle : robot.obstacles) {
    shapes.push_back(Shape::Segment(ShapeRole::kFixture, "obstacle", obstacle.radius));
    shapes.back().p_W = obstacle.from_W;
    shapes.back().vector_W = obstacle.to_W - obstacle.from_W;
  }
  return shapes;
}

void MoveCdprGeometry(const CdprDescription& robot, const PlatformState& platform, const CableVector& tension,
                      const std::vector<CableStatics>& cables, const Payload& payload,
                      const PlatformWrench& wrench, Geometry* geometry) {
  Geometry& shapes = *geometry;
  const Eigen::Matrix3d R_WB = platform.R_WB();
  shapes[kPlatform].p_W = shapes[kPath].p_W = shapes[kForce].p_W = platform.p_WB;
  shapes[kPlatform].q_W = platform.q_WB.normalized();
  shapes[kForce].vector_W = wrench.force_W;

  Shape& ball = shapes[kPayloadBall];
  ball.visible = payload.mass > 0;
  ball.p_W = platform.p_WB + R_WB * payload.p_B;
  const std::size_t pieces = PiecesPerCable(robot);
  const bool has_pulleys = robot.has_pulleys();
  const std::size_t first_fixture = kFirstCable + robot.cables.size() * (pieces + (has_pulleys ? 1 : 0));
  for (std::size_t i = 0; i < robot.cables.size(); ++i) {
    const CableStatics& cable = cables[i];
    PlaceFixture(cable.anchor_W, robot.floor, &shapes[first_fixture + 2 * i]);
    const Vec<3> swivel_W = platform.p_WB + R_WB * robot.cables[i].attachment_B;
    const Vec<3> attachment_W = swivel_W + cable.lead_W;
    Vec<3> from_W = attachment_W;
    for (std::size_t k = 0; k < pieces; ++k) {
      Vec<3> to_W = cable.exit_W;
      if (k + 1 < pieces) {
        const double part = static_cast<double>(k + 1) / static_cast<double>(pieces);
        const Vec<2> point = cable.catenary.PointAt(part * cable.catenary.rest_length);
        to_W = attachment_W + point[0] * cable.toward_W + Vec<3>(0, 0, point[1]);
      }
      Shape& piece = shapes[kFirstCable + i * pieces + k];
      piece.p_W = from_W;
      piece.vector_W = to_W - from_W;
      piece.value = tension[i];
      from_W = to_W;
    }
    if (!has_pulleys) continue;
    const double radius = robot.pulley_radius(i);
    Shape& pulley = shapes[kFirstCable + robot.cables.size() * pieces + i];
    pulley.visible = radius > 0;
    const bool carried = robot.carries_pulley(i);
    pulley.p_W = (carried ? swivel_W : cable.anchor_W) + radius * cable.plane_W;
    // A quarter turn about the direction of the plane brings the swivel axis to the pulley's axle.
    const double half = std::numbers::sqrt2 / 2;
    pulley.q_W = {half, half * cable.plane_W[0], half * cable.plane_W[1], half * cable.plane_W[2]};
    if (carried) pulley.q_W = QuaternionProduct(pulley.q_W, shapes[kPlatform].q_W);
  }
  const std::size_t first_spring = first_fixture + 2 * robot.cables.size();
  for (std::size_t i = 0; i < robot.springs.size(); ++i)
    shapes[first_spring + i].vector_W =
        platform.p_WB + R_WB * robot.springs[i].attachment_B - robot.springs[i].anchor_W;
}

}  // namespace tenon
