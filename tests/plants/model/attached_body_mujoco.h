#pragma once

#include <tenon/plants/attached_bodies.h>
#include <tenon/tests/plants/model/quadruped_mujoco.h>

namespace tenon::test {

/// A link of 2 kg on a pin with spring and damper, which reaches from its joint along z, down if negative
/// [m].
inline AttachedBody SpringLink(const std::string& name, const Vec<3>& position, const Vec<3>& axis,
                               double reach) {
  return {.name = name,
          .position = position,
          .axis = axis,
          .mass = 2,
          .centre = {0.02, 0, reach / 2},
          .edges = {0.06, 0.08, std::abs(reach)},
          .stiffness = 25,
          .damping = 0.3};
}

/// The box of an attached body on a pin, without its end tag.
inline std::string Mjcf(const AttachedBody& link) {
  return fmt::format(R"(<body pos="{}"><joint type="hinge" axis="{}" stiffness="{}" damping="{}"/>{})",
                     Numbers(link.position), Numbers(link.axis.normalized()), link.stiffness, link.damping,
                     Inertial(UniformBoxInertia(link.mass, link.centre, link.edges)));
}

}  // namespace tenon::test
