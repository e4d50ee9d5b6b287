#pragma once

#include <string>

namespace tenon::test {

/// The URDF of a shipped robot whose trunk is the link `trunk`, with an arm on it: a yaw joint, two joints
/// with skew axes in turned frames, and a gripper that a fixed joint connects to the last link.
inline std::string WithArm(std::string urdf) {
  const auto link = [](const std::string& name, const std::string& mass, const std::string& x) {
    return "<link name=\"" + name + "\"><inertial><origin xyz=\"" + x +
           " 0.01 0.03\" rpy=\"0.1 0.2 0.3\"/><mass value=\"" + mass +
           "\"/><inertia ixx=\"0.001\" ixy=\"0.0002\" ixz=\"0.0001\" iyy=\"0.004\" iyz=\"0\" izz=\"0.0045\"/>"
           "</inertial></link>";
  };
  const auto joint = [](const std::string& name, const std::string& type, const std::string& parent,
                        const std::string& child, const std::string& origin, const std::string& axis) {
    return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><origin " + origin + "/><axis xyz=\"" + axis +
           "\"/><limit effort=\"40\" velocity=\"10\" lower=\"-2\" upper=\"2\"/></joint>";
  };
  const std::string arm =
      link("shoulder", "0.8", "0") + link("upper_arm", "1.1", "0.15") + link("forearm", "0.7", "0.12") +
      link("gripper", "0.3", "0.02") +
      joint("arm_yaw", "revolute", "trunk", "shoulder", "xyz=\"0.1 0 0.08\" rpy=\"0 0 0.2\"", "0 0 1") +
      joint("arm_pitch", "revolute", "shoulder", "upper_arm", "xyz=\"0 0.02 0.05\" rpy=\"0.3 -0.4 0\"",
            "0.1 1 0") +
      joint("arm_elbow", "revolute", "upper_arm", "forearm", "xyz=\"0.3 0 0\" rpy=\"0 0.7 0.1\"",
            "0 1 -0.2") +
      joint("gripper_mount", "fixed", "forearm", "gripper", "xyz=\"0.25 0 0\" rpy=\"0 0 0.5\"", "1 0 0");
  return urdf.insert(urdf.rfind("</robot>"), arm);
}

}  // namespace tenon::test
