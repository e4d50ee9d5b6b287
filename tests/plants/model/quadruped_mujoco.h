#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/quaternion.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/LU>
#include <fmt/format.h>
#include <mujoco/mujoco.h>

namespace tenon::test {

inline std::string Numbers(const Eigen::Vector3d& v) {
  return fmt::format("{} {} {}", v[0], v[1], v[2]);
}

/// Given by principal axes, because MuJoCo computes them from a full inertia to 1e-8 only.
inline std::string Inertial(const RigidInertia& body) {
  const SymmetricModes principal(body.inertia);
  Eigen::Matrix3d axes = principal.eigenvectors;
  if (axes.determinant() < 0) axes.col(0) *= -1;
  const Vec<4> q = QuaternionFromRotation(axes);
  return fmt::format(R"(<inertial pos="{}" quat="{} {} {} {}" mass="{}" diaginertia="{}"/>)",
                     Numbers(body.com), q[0], q[1], q[2], q[3], body.mass, Numbers(principal.eigenvalues));
}

/// The plane z = 0, which the feet can touch, with friction 1.
inline constexpr const char* kLevelGround =
    R"(<geom type="plane" size="9 9 1" contype="1" conaffinity="0"/>)";

/// The robot in MJCF with MuJoCo's default contact parameters and joints in Tenon's order. The feet, and only
/// they, touch the `ground`; without it they have no shapes. `on_trunk` are further bodies and shapes, and
/// `on_shanks` shapes of all shanks.
inline std::string Mjcf(const QuadrupedDescription& robot, const std::string& ground = "",
                        const std::string& on_trunk = "", const std::string& on_shanks = "") {
  std::string text = "<mujoco><compiler angle=\"radian\"/><option gravity=\"0 0 -9.81\"/><worldbody>" +
                     ground + "<body><freejoint/>" + Inertial(robot.trunk);
  for (const LegDescription& leg : robot.legs) {
    for (std::size_t i = 0; i < kJointsPerLeg; ++i)
      text += fmt::format("<body pos=\"{}\"><joint type=\"hinge\" axis=\"{}\" armature=\"{}\"/>{}",
                          Numbers(leg.joints[i].p_PJ), Numbers(leg.joints[i].axis), robot.drive.rotor_inertia,
                          Inertial(leg.bodies[i]));
    if (!ground.empty())
      text += fmt::format("<geom type=\"sphere\" size=\"{}\" pos=\"{}\" contype=\"0\" conaffinity=\"1\"/>",
                          robot.foot_radius, Numbers(leg.foot_J));
    text += on_shanks + "</body></body></body>";
  }
  return text + on_trunk + "</body></worldbody></mujoco>";
}

struct FreeMuJoCo {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using MuJoCoModel = std::unique_ptr<mjModel, FreeMuJoCo>;
using MuJoCoData = std::unique_ptr<mjData, FreeMuJoCo>;

inline MuJoCoModel LoadMuJoCo(const std::string& mjcf) {
  const auto files = std::make_unique<mjVFS>();  // 2 MB: not on the stack
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "robot.xml", static_cast<int>(mjcf.size()));
  std::memcpy(files->filedata[0], mjcf.data(), mjcf.size());
  char error[1000] = "";
  MuJoCoModel model(mj_loadXML("robot.xml", files.get(), error, sizeof(error)));
  mj_deleteVFS(files.get());
  if (model == nullptr) throw std::runtime_error(error);
  return model;
}

}  // namespace tenon::test
