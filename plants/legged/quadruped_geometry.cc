#include <tenon/plants/legged/quadruped_geometry.h>
#include <tenon/plants/model/vectors.h>

#include <algorithm>

namespace tenon {
namespace {

constexpr double kPlaneSize = 12;         // edge of the slab of a slope [m]
constexpr double kPlaneThickness = 0.02;  // [m]
constexpr double kBoxDepth = 0.01;        // depth of boxes below the plane, so that no gap is visible [m]
constexpr int kNumBodies = 1 + kNumJoints;

// Indices of the shapes; the terrain follows after kNumMoving.
enum Index {
  kTrunk,
  kPayload,
  kPath,
  kFirstLink,
  kFirstFoot = kFirstLink + kNumJoints,
  kFirstFootForce = kFirstFoot + kNumLegs,
  kFirstExternal = kFirstFootForce + kNumLegs,
  kNumMoving = kFirstExternal + kMaxExternalForces
};

/// Edges of the trunk's uniform box, widened to the first joints of the legs [m].
Vec<3> TrunkEdges(const QuadrupedDescription& robot) {
  Vec<3> edges = UniformBox(robot.trunk);
  for (const LegDescription& leg : robot.legs)
    edges = edges.cwiseMax(2 * (leg.joints[0].p_PJ - robot.trunk.com).cwiseAbs());
  return edges;
}

/// The shape of a collision shape, and its pose.
Shape ShapeOf(const RoundedBox& box, int number) {
  const std::string name = "collision shape " + std::to_string(number) + " of the trunk";
  const bool is_round = box.radius > 0 && box.half.head<2>().isZero(0);
  if (is_round && box.half[2] == 0) return Shape::Sphere(ShapeRole::kCollision, name, box.radius);
  if (is_round) return Shape::Capsule(ShapeRole::kCollision, name, box.radius, 2 * box.half[2]);
  return Shape::Box(ShapeRole::kCollision, name, 2 * (box.half + Vec<3>::Constant(box.radius)));
}
void Move(const RoundedBox& box, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB, Shape* shape) {
  shape->p_W = p_WB + R_WB * box.p_B;
  shape->q_W = QuaternionFromRotation(R_WB * box.R_BS);
}

/// Whether contact of the trunk is judged by other shapes than the one that is drawn.
bool JudgesTrunkByOthers(const QuadrupedDescription& robot) {
  return !robot.trunk_shapes.empty() || robot.meshes[0] != nullptr;
}

/// End of a link in its joint's frame: the next joint, or the foot [m].
const Eigen::Vector3d& LinkEnd(const QuadrupedDescription& robot, int joint) {
  return joint % kJointsPerLeg == kJointsPerLeg - 1 ? robot.legs[joint / kJointsPerLeg].foot_J
                                                    : robot.joint(joint + 1).p_PJ;
}

void AddTerrain(const TerrainParams& params, Geometry* shapes) {
  const Terrain terrain(params);
  const Vec<4> q_WS = QuaternionFromRotation(terrain.R_WS());
  if (!params.grade.isZero(0)) {
    Shape slope = Shape::Box(ShapeRole::kGround, "slope", {kPlaneSize, kPlaneSize, kPlaneThickness});
    slope.p_W = terrain.R_WS() * Vec<3>(0, 0, -kPlaneThickness / 2);
    slope.q_W = q_WS;
    shapes->push_back(std::move(slope));
  }
  for (std::size_t i = 0; i < terrain.boxes().size(); ++i) {
    const TerrainBox& box = terrain.boxes()[i];
    Shape shape = Shape::Box(ShapeRole::kGround, "box " + std::to_string(i),
                             {box.size[0], box.size[1], box.height + kBoxDepth});
    shape.p_W = terrain.R_WS() * Vec<3>(box.centre[0], box.centre[1], (box.height - kBoxDepth) / 2);
    shape.q_W = q_WS;
    shapes->push_back(std::move(shape));
  }
}

}  // namespace

// The moment of inertia about the first axis is m (b^2 + c^2) / 12.
Eigen::Vector3d UniformBox(const RigidInertia& body) {
  if (body.mass == 0) return Eigen::Vector3d::Zero();
  const Vec<3> I = body.inertia.diagonal();
  const Vec<3> squares = 6 / body.mass * (Vec<3>::Constant(I.sum()) - 2 * I);
  return squares.cwiseMax(0.0).cwiseSqrt();
}

RoundedBox BoxBetweenHips(const QuadrupedDescription& robot) {
  Eigen::Vector3d low = robot.legs[0].joints[0].p_PJ, high = low;
  for (const LegDescription& leg : robot.legs) {
    low = low.cwiseMin(leg.joints[0].p_PJ);
    high = high.cwiseMax(leg.joints[0].p_PJ);
  }
  RoundedBox box;
  box.p_B = (low + high) / 2;
  box.half = (high - low) / 2;
  box.p_B[2] = robot.trunk.com[2];
  box.half[2] = UniformBox(robot.trunk)[2] / 2;
  if (robot.trunk_shapes.empty()) return box;
  double lowest = HUGE_VAL, highest = -HUGE_VAL;
  for (const RoundedBox& shape : robot.trunk_shapes) {
    const Eigen::Vector3d extent =
        shape.R_BS.cwiseAbs() * shape.half + Eigen::Vector3d::Constant(shape.radius);
    const Eigen::Vector3d apart = (shape.p_B - box.p_B).cwiseAbs() - extent - box.half;
    if (apart.head<2>().maxCoeff() > 0) continue;  // a head or an arm before the hips
    lowest = std::min(lowest, shape.p_B[2] - extent[2]);
    highest = std::max(highest, shape.p_B[2] + extent[2]);
  }
  if (lowest > highest) return box;
  box.p_B[2] = (lowest + highest) / 2;
  box.half[2] = (highest - lowest) / 2;
  return box;
}

double LinkRadius(const QuadrupedDescription& robot) {
  return 0.8 * robot.foot_radius;
}

Geometry MakeQuadrupedGeometry(const QuadrupedDescription& robot, const RigidInertia& payload,
                               const TerrainParams& terrain) {
  const double force_scale = 2 * robot.StanceHeight() / (kGravity * robot.mass());  // [m/N]
  Geometry shapes(kNumMoving);
  const auto with_mesh = [&](Shape plain, int body) {
    const auto& mesh = robot.meshes[body];
    return mesh == nullptr ? plain : Shape::Mesh(plain.role, std::move(plain.name), mesh);
  };
  shapes[kTrunk] = with_mesh(Shape::Box(ShapeRole::kBody, "trunk", TrunkEdges(robot)), 0);
  shapes[kPayload] = Shape::Box(ShapeRole::kLoad, "payload", UniformBox(payload));
  shapes[kPayload].visible = payload.mass > 0;
  shapes[kPath] = Shape::Trace(ShapeRole::kBody, "path of the trunk");
  const auto capsule = [&](ShapeRole role, const std::string& name, int j) {
    return Shape::Capsule(role, name + robot.joint(j).name, LinkRadius(robot), LinkEnd(robot, j).norm());
  };
  for (int j = 0; j < kNumJoints; ++j)
    shapes[kFirstLink + j] = with_mesh(capsule(ShapeRole::kBody, "link of ", j), j + 1);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const std::string name = kLegNames[leg];
    shapes[kFirstFoot + leg] = Shape::Sphere(ShapeRole::kBody, "foot " + name, robot.foot_radius);
    shapes[kFirstFootForce + leg] = Shape::Arrow(ShapeRole::kForce, "force on " + name, force_scale);
  }
  for (int i = 0; i < kMaxExternalForces; ++i)
    shapes[kFirstExternal + i] =
        Shape::Arrow(ShapeRole::kDisturbance, "external force " + std::to_string(i), force_scale);
  AddTerrain(terrain, &shapes);
  for (int j = 0; j < kNumJoints; ++j)
    if (robot.meshes[j + 1] != nullptr)
      shapes.push_back(capsule(ShapeRole::kCollision, "collision shape of ", j));
  if (!JudgesTrunkByOthers(robot)) return shapes;
  for (const RoundedBox& box : robot.trunk_shapes)
    shapes.push_back(ShapeOf(box, static_cast<int>(shapes.size())));
  shapes.push_back(ShapeOf(BoxBetweenHips(robot), 0));
  return shapes;
}

void MoveQuadrupedGeometry(const QuadrupedDescription& robot, const RigidInertia& payload,
                           const LeggedState& x, const FootForces& feet, const ExternalForces& external,
                           Geometry* geometry) {
  Geometry& shapes = *geometry;
  std::array<Eigen::Matrix3d, kNumBodies> R_W{x.R_WB()};
  std::array<Eigen::Vector3d, kNumBodies> p_W{x.p_WB};
  shapes[kTrunk].p_W = x.p_WB;
  if (robot.meshes[0] == nullptr) shapes[kTrunk].p_W += R_W[0] * robot.trunk.com;
  shapes[kPayload].p_W = x.p_WB + R_W[0] * payload.com;
  shapes[kTrunk].q_W = shapes[kPayload].q_W = x.q_WB.normalized();
  shapes[kPath].p_W = x.p_WB;

  std::size_t judged = shapes.size();
  if (JudgesTrunkByOthers(robot)) {
    const std::size_t n = robot.trunk_shapes.size();
    judged -= n + 1;
    for (std::size_t i = 0; i < n; ++i) Move(robot.trunk_shapes[i], p_W[0], R_W[0], &shapes[judged + i]);
    Move(BoxBetweenHips(robot), p_W[0], R_W[0], &shapes[judged + n]);
  }
  for (std::size_t body = 1; body < kNumBodies; ++body) judged -= robot.meshes[body] != nullptr ? 1 : 0;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const LegPose pose = robot.PoseOfLeg(leg, x.q);
    for (int i = 0; i < kJointsPerLeg; ++i) {
      const int joint = kJointsPerLeg * leg + i;
      const int body = joint + 1;
      p_W[body] = x.p_WB + R_W[0] * pose.p_BJ[i];
      R_W[body] = R_W[0] * pose.R_BJ[i];
      Shape& link = shapes[kFirstLink + joint];
      const bool has_mesh = robot.meshes[body] != nullptr;
      if (has_mesh) {
        link.p_W = p_W[body];
        link.q_W = QuaternionFromRotation(R_W[body]);
      }
      Shape& capsule = has_mesh ? shapes[judged++] : link;
      const Eigen::Vector3d along_W = R_W[body] * LinkEnd(robot, joint);
      const auto turn = RotationBetween(Eigen::Vector3d::UnitZ(), along_W);
      capsule.p_W = p_W[body] + along_W / 2;
      capsule.q_W = {turn.w(), turn.x(), turn.y(), turn.z()};
    }
    Shape& force = shapes[kFirstFootForce + leg];
    force.p_W = shapes[kFirstFoot + leg].p_W = x.p_WB + R_W[0] * pose.foot_B;
    force.vector_W = feet[leg];
  }
  for (std::size_t i = 0; i < external.size(); ++i) {
    const ExternalForce& force = external[i];
    Shape& arrow = shapes[kFirstExternal + i];
    arrow.visible = force.body >= 0 && force.body < kNumBodies;
    if (!arrow.visible) continue;
    arrow.p_W = p_W[force.body] + R_W[force.body] * force.p_B;
    arrow.vector_W = force.force_W;
  }
}

}  // namespace tenon
