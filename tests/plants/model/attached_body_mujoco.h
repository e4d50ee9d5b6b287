#pragma once

#include <tenon/plants/multibody/attached_bodies.h>
#include <tenon/tests/plants/model/quadruped_mujoco.h>

namespace tenon::test {

/// The box of an attached body on a pin, without its end tag.
inline std::string Mjcf(const AttachedBody& link) {
  return fmt::format(R"(<body pos="{}"><joint type="hinge" axis="{}" stiffness="{}" damping="{}"/>{})",
                     Numbers(link.position), Numbers(link.axis.normalized()), link.stiffness, link.damping,
                     Inertial(UniformBoxInertia(link.mass, link.centre, link.edges)));
}

}  // namespace tenon::test
