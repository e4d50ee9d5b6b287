#include <tenon/controllers/cdpr/loaded_platform.h>

namespace tenon {
namespace {

Eigen::Matrix3d PointInertia(double mass, const Eigen::Vector3d& r) {
  return mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
}

}  // namespace

LoadedPlatform::LoadedPlatform(const CdprDescription& robot, const Payload& payload)
    : mass(robot.mass), inertia(robot.inertia_B) {
  if (payload.mass == 0) return;
  mass += payload.mass;
  com_B = payload.mass / mass * payload.p_B;
  inertia += PointInertia(robot.mass, com_B) + PointInertia(payload.mass, payload.p_B - com_B);
}

}  // namespace tenon
