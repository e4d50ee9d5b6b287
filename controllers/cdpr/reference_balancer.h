#pragma once

#include <tenon/controllers/cdpr/balanced_reference.h>
#include <tenon/systems/block.h>

namespace tenon {

struct ReferenceBalancerParams {
  CdprDescription robot;  ///< model of the controller
  Rate rate = Hz(1000);
};

/// Feedforward for controllers that follow a CdprReference: replaces its attitude, tensions and cable lengths
/// by those that are consistent with its acceleration, the load on the platform and broken cables, see
/// BalancedReference. Position and velocities are unchanged.
class ReferenceBalancer final : public LeafSystem<ReferenceBalancerParams> {
 public:
  using LeafSystem::LeafSystem;
  const MovingAnchors anchors{params.robot};
  InputPort<CdprReference> reference{this, {"reference"}};
  InputPort<LoadEstimate> load{this, {"load"}, LoadEstimate{}};
  InputPort<CableVector> broken{this, {"broken"}, CableVector{}};
  Scratch<ReferenceShift> shift{this, "shift",
                                ReferenceShift{Vec<3>::Zero(), CableVector::Zero(params.robot.num_cables())}};
  Workspace<BalancedReference> work{this, "work", BalancedReference(params.robot)};
  OutputPort<CdprReference> balanced{this,
                                     {"balanced"},
                                     Empty(params.robot.num_cables()),
                                     Sampled{params.rate},
                                     Uses(time, reference, load, broken, shift, work),
                                     &ReferenceBalancer::CalcBalanced};

 private:
  static CdprReference Empty(int num_cables);
  void CalcBalanced(double time, const CdprReference& reference, const LoadEstimate& load,
                    const CableVector& broken, ReferenceShift& shift, BalancedReference& work,
                    CdprReference* balanced) const;
};

}  // namespace tenon
