#include <tenon/diagrams/legged/quadruped_messages.h>

#include <Eigen/Geometry>

namespace tenon {
namespace {

using namespace ros2;

std::string ContactFrame(int leg) {
  return std::string("contact_") + kLegNames[static_cast<std::size_t>(leg)];
}

geometry_msgs::TransformStamped FrameOf(const RobotLinks::Link& link) {
  auto frame = MakeTransform(link.parent, link.name);
  Set(link.position, &frame.transform.translation);
  frame.transform.rotation = QuaternionOf(QuaternionFromRotation(link.rotation));
  return frame;
}

/// Centre of mass in B [m].
Eigen::Vector3d CentreOfMass(const QuadrupedDescription& robot, const Vec<12>& q) {
  Eigen::Vector3d sum = robot.trunk.mass * robot.trunk.com;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const LegPose pose = robot.PoseOfLeg(leg, q);
    for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
      const RigidInertia& body = robot.legs[static_cast<std::size_t>(leg)].bodies[i];
      sum += body.mass * (pose.p_BJ[i] + pose.R_BJ[i] * body.com);
    }
  }
  return sum / robot.mass();
}

}  // namespace

sensor_msgs::JointState QuadrupedMessages::MakeJoints() const {
  std::vector<std::string> names;
  for (int j = 0; j < kNumJoints; ++j) names.push_back(params.robot.joint(j).name);
  return MakeJointState(names);
}

void QuadrupedMessages::CalcJoints(double t, const JointMotion& motion, const Vec<12>& effort,
                                   sensor_msgs::JointState* out) const {
  out->header.stamp = StampOf(params.epoch + t);
  for (int j = 0; j < kNumJoints; ++j) {
    const auto i = static_cast<std::size_t>(j);
    out->position[i] = motion.q[j];
    out->velocity[i] = motion.qd[j];
    out->effort[i] = effort[j];
  }
}

sensor_msgs::JointState QuadrupedMessages::MakeCommands() const {
  sensor_msgs::JointState commands = MakeJoints();
  commands.position.clear();
  commands.velocity.clear();
  return commands;
}

void QuadrupedMessages::CalcCommands(double t, const Vec<12>& torque, sensor_msgs::JointState* out) const {
  out->header.stamp = StampOf(params.epoch + t);
  Eigen::Map<Vec<12>>(out->effort.data()) = torque;
}

void QuadrupedMessages::CalcDisturbance(double t, const LeggedState& x, const WrenchEstimate& estimate,
                                        Wrench* out) const {
  const Eigen::Matrix3d R_BW = x.R_WB().transpose();
  const Eigen::Vector3d force_B = R_BW * estimate.force_W;
  out->header.stamp = StampOf(params.epoch + t);
  Set(force_B, &out->wrench.force);
  Set(R_BW * estimate.torque_W + CentreOfMass(params.robot, x.q).cross(force_B), &out->wrench.torque);
}

tf2_msgs::TFMessage QuadrupedMessages::MakeTf(bool at_rest) const {
  tf2_msgs::TFMessage made;
  if (!at_rest) made.transforms.push_back(MakeTransform(kOdom, params.links.base));
  for (const RobotLinks::Link& link : params.links.links)
    if ((link.joint < 0) == at_rest) made.transforms.push_back(FrameOf(link));
  for (int leg = 0; leg < kNumLegs && !at_rest; ++leg)
    made.transforms.push_back(MakeTransform(params.links.base, ContactFrame(leg)));
  return made;
}

void QuadrupedMessages::CalcTf(double t, const LeggedState& x, tf2_msgs::TFMessage* out) const {
  for (auto& frame : out->transforms) frame.header.stamp = StampOf(params.epoch + t);
  auto frame = out->transforms.begin();
  Set(x.p_WB, &frame->transform.translation);
  frame->transform.rotation = QuaternionOf(x.q_WB);
  for (const RobotLinks::Link& link : params.links.links) {
    if (link.joint < 0) continue;
    const Eigen::Matrix3d turned = link.rotation * Eigen::AngleAxisd(x.q[link.joint], link.axis);
    (++frame)->transform.rotation = QuaternionOf(QuaternionFromRotation(turned));
  }
  for (int leg = 0; leg < kNumLegs; ++leg)
    Set(params.robot.FootPosition(leg, x.q), &(++frame)->transform.translation);
}

OutputPort<QuadrupedMessages::Wrench> QuadrupedMessages::MakeFoot(int leg) {
  return {this, Spec{kLegNames[static_cast<std::size_t>(leg)]}, Wrench{{{}, ContactFrame(leg)}, {}},
          Uses(time, state, foot_forces),
          [this, leg](double t, const LeggedState& x, const FootForces& forces, Wrench* out) {
            out->header.stamp = StampOf(params.epoch + t);
            Set(x.R_WB().transpose() * forces[leg], &out->wrench.force);
          }};
}

}  // namespace tenon
