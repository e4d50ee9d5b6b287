#pragma once

#include <tenon/plants/model/rope.h>
#include <tenon/systems/block.h>
#include <tenon/systems/geometry.h>

namespace tenon {

struct RopesParams {
  std::vector<Rope> ropes;
  void Validate() const { CheckRopes(ropes); }
};

/// Ropes that pull a quadruped's trunk towards anchors in the world. With the attachment p and the anchor a
/// of a rope, its force on the trunk is
///
///     f = T (a - p) / |a - p|,   T the commanded tension within [0, tension_max].
///
/// The winches are on the trunk and control the tension: they reel in and pay out as the robot moves. A
/// HeldLag before `command` is the response of such a winch. The ropes have no mass and no elasticity, and
/// touch nothing between their ends; docs/cdpr_cables.md describes the cables of a cable robot, which have.
///
/// `force` is the resultant on the trunk about B's origin, and the colours in `geometry` show the tensions.
///
/// Throws RunError if an anchor and its attachment coincide.
class Ropes final : public LeafSystem<RopesParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> robot{this, {"robot"}};
  InputPort<CableVector> command{this, {"command", "N", RopeElements(params.ropes)}};
  OutputPort<CableVector> tension{this,
                                  {"tension", "N", RopeElements(params.ropes)},
                                  CableVector::Zero(static_cast<Eigen::Index>(params.ropes.size())),
                                  Uses(command),
                                  &Ropes::CalcTension};
  OutputPort<ExternalForce> force{this, {"force"}, Uses(robot, tension), &Ropes::CalcForce};
  OutputPort<Geometry> geometry{
      this, {"geometry"}, MakeGeometry(), Uses(robot, tension), &Ropes::CalcGeometry};

 private:
  void CalcTension(const CableVector& command, CableVector* tension) const;
  ExternalForce CalcForce(const LeggedState& robot, const CableVector& tension) const;
  Geometry MakeGeometry() const;
  void CalcGeometry(const LeggedState& robot, const CableVector& tension, Geometry* geometry) const;
};

}  // namespace tenon
