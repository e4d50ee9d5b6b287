#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct WalkViewParams {
  QuadrupedDescription robot;
};

/// Shapes of a replay that show signals of a walking controller: the path of the CoM's reference, the
/// estimated force on the CoM, and the estimated forces on the legs, drawn at the feet.
class WalkView final : public LeafSystem<WalkViewParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<BodyReference> body{this, {"body"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  InputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                MakeShapes(params.robot),
                                Uses(state, body, wrench, leg_forces),
                                &WalkView::CalcGeometry};

 private:
  static Geometry MakeShapes(const QuadrupedDescription& robot);
  void CalcGeometry(const LeggedState& state, const BodyReference& body, const WrenchEstimate& wrench,
                    const LegForceEstimate& leg_forces, Geometry* geometry) const;
};

}  // namespace tenon
