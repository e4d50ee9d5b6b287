#include <tenon/diagrams/cdpr/cdpr_profile.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon {
CdprScale ScaleOf(const CdprDescription& robot, const Eigen::Vector3d& p_WB, double gravity) {
  CdprScale scale;
  scale.mass = robot.mass;
  scale.gravity = gravity;
  double length = 0, square = 0;
  for (const CableDescription& cable : robot.cables) {
    length += (cable.anchor_W - p_WB - cable.attachment_B).norm();
    square += cable.attachment_B.squaredNorm();
  }
  scale.length = length / robot.num_cables();
  scale.arm = std::sqrt(square / robot.num_cables());
  return scale;
}

CdprProfile LoadCdprProfile(const YamlFile& file, const CdprScale& scale) {
  return LoadResource("profiles", file, "mpc").Read<CdprProfile>(&scale);
}

}  // namespace tenon
