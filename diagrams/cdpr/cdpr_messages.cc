#include <tenon/diagrams/cdpr/cdpr_messages.h>

#include <fmt/core.h>

namespace tenon {

using namespace ros2;

sensor_msgs::JointState CdprMessages::MakeCables() const {
  std::vector<std::string> names;
  for (int i = 1; i <= params.num_cables; ++i) names.push_back(fmt::format("cable_{}", i));
  return MakeJointState(names);
}

void CdprMessages::CalcCables(double t, const CableSignals& measured, sensor_msgs::JointState* out) const {
  out->header.stamp = StampOf(t);
  for (std::size_t i = 0; i < out->name.size(); ++i) {
    const auto cable = static_cast<Eigen::Index>(i);
    out->position[i] = measured.length[cable];
    out->velocity[i] = measured.length_rate[cable];
    out->effort[i] = measured.tension[cable];
  }
}

void CdprMessages::CalcDisturbance(double t, const PlatformState& x, const LoadEstimate& estimate,
                                   Wrench* out) const {
  const Eigen::Matrix3d R_BW = x.R_WB().transpose();
  out->header.stamp = StampOf(t);
  Set(R_BW * estimate.rest.force_W, &out->wrench.force);
  Set(R_BW * estimate.rest.torque_W, &out->wrench.torque);
}

void CdprMessages::CalcTf(double t, const PlatformState& x, tf2_msgs::TFMessage* out) const {
  geometry_msgs::TransformStamped& frame = out->transforms.front();
  frame.header.stamp = StampOf(t);
  Set(x.p_WB, &frame.transform.translation);
  frame.transform.rotation = QuaternionOf(x.q_WB);
}

}  // namespace tenon
