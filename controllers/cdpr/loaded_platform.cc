#include <tenon/controllers/cdpr/loaded_platform.h>
#include <tenon/plants/model/rigid_inertia.h>

namespace tenon {

LoadedPlatform::LoadedPlatform(const CdprDescription& robot, const Payload& payload)
    : mass(robot.mass), inertia(robot.inertia_B) {
  if (payload.mass == 0) return;
  mass += payload.mass;
  com_B = payload.mass / mass * payload.p_B;
  inertia += PointInertia(robot.mass, com_B) + PointInertia(payload.mass, payload.p_B - com_B);
}

}  // namespace tenon
