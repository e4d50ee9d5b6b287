#pragma once

#include <tenon/plants/legged/quadruped_body.h>

namespace tenon {

/// Contact of trunk, hips, knees and shanks with the terrain, for a robot that lies, falls or gets up.
///
/// The bodies are represented by spheres: at the corners of QuadrupedDescription::trunk_shapes, or without
/// them of BoxBetweenHips, and at the joints of hip and knee with LinkRadius. With the foot, the sphere of
/// the knee bounds the shank, so its middle may cut the edge of a box. Sharp edges are rounded by 5 mm. A
/// sphere has the contact of a foot, see foot_contact.h, but ten times its stiffness, since shells are harder
/// than feet, and no state: its bristle has the deflection z = v T of the tangential velocity v, with a time
/// T = 10 ms, and at most 0.7 z_max of the most slippery ground. Friction is thus viscous below a few cm/s,
/// and a robot that lies on a slope creeps.
///
/// While no part is near the highest point of the terrain, nothing is evaluated but the heights of the knees
/// and of a box around all other spheres.
class BodyContact {
 public:
  BodyContact(const QuadrupedDescription& robot, const TerrainParams& terrain);

  /// Forces on trunk, hips and thighs, one for each of these bodies that touches the ground.
  struct Forces {
    std::array<PointForce, 1 + 2 * kNumLegs> at;
    std::size_t count = 0;
  };
  void CalcForces(const QuadrupedBody& body, const LeggedState& x, Forces* out) const;

 private:
  struct Sphere {
    int body;
    Vec<3> p;  ///< centre in the body's frame [m]
    double radius;
  };
  Terrain terrain_;
  ContactProperties contact_;
  std::vector<Sphere> spheres_;  // the knees come last
  Vec<3> middle_, half_;         // of a box in B around all spheres but those of the knees [m]
  double top_ = 0;               // height of the terrain above its plane [m]
};

}  // namespace tenon
