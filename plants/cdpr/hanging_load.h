#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/geometry.h>

namespace tenon {

struct HangingLoadParams {
  double mass = 1;                       ///< m, a point mass [kg]
  double length = 1;                     ///< l_0, rest length of the rope [m]
  Vec<3> attachment_B = Vec<3>::Zero();  ///< attachment of the rope at the platform, from its CoM [m]
  double axial_stiffness = 27000;        ///< EA of the rope [N]; default: a polymer rope of 5 mm
  double axial_damping = 135;            ///< EA times the material's damping time [N s]
  Vec<3> p_W = Vec<3>::Zero();           ///< position of the load at the start, when it is at rest [m]
  double gravity = kGravity;             ///< [m/s^2]

  static FieldList Fields() {
    using P = HangingLoadParams;
    return {Required("mass_kg", &P::mass).Positive(),
            Required("length_m", &P::length).Positive(),
            Field("attachment_m", &P::attachment_B).Finite(),
            Undescribed("axial_stiffness", &P::axial_stiffness).Positive(),
            Undescribed("axial_damping", &P::axial_damping).AtLeast(0).Because("the rope would swing up"),
            Undescribed("p_W", &P::p_W).Finite(),
            Undescribed("gravity", &P::gravity).Positive()};
  }
};

/// Position and velocity of a load on a rope.
struct HangingLoadState {
  Vec<3> p_W = Vec<3>::Zero();  ///< [m]
  Vec<3> v_W = Vec<3>::Zero();  ///< [m/s]

  static FieldList Fields() {
    return {{"p_W", &HangingLoadState::p_W, "m"}, {"v_W", &HangingLoadState::v_W, "m/s"}};
  }
};

/// A point mass that swings on a rope under the platform. The rope is modelled like the cables of CdprPlant:
/// with its length l and the direction e from the attachment to the load,
///
///     T = max(0, EA / l_0 (l - l_0) + damping / l_0 dl/dt) if l > l_0, else 0
///     m dv/dt = -T e + m g
///
/// The platform receives the force T e at the attachment.
class HangingLoad final : public LeafSystem<HangingLoadParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<PlatformState> platform{this, {"platform"}};
  InputPort<PlatformWrench> others{this, {"others"}, PlatformWrench{}};
  ContinuousState<HangingLoadState> state{this, {"state"}, {params.p_W, Vec<3>::Zero()}};

  /// State of the rope.
  struct Rope {
    Vec<3> arm_W = Vec<3>::Zero();    ///< vector from the platform's CoM to the attachment [m]
    Vec<3> force_W = Vec<3>::Zero();  ///< on the platform [N]
  };
  Shared<Rope> rope{this, "rope", Uses(platform, state), &HangingLoad::CalcRope};
  OutputPort<PlatformWrench> wrench{this, {"wrench"}, Uses(rope, others), &HangingLoad::CalcWrench};
  OutputPort<HangingLoadState> load{this, {"load"}, state};
  OutputPort<double> tension{
      this, {"tension", "N"}, Uses(rope), [](const Rope& rope_now) { return rope_now.force_W.norm(); }};
  OutputPort<Geometry> geometry{
      this, {"geometry"}, MakeGeometry(), Uses(platform, state, rope), &HangingLoad::CalcGeometry};
  TimeDerivative<HangingLoadState> rate{state, Uses(state, rope), &HangingLoad::CalcRate};

 private:
  static Geometry MakeGeometry();
  Rope CalcRope(const PlatformState& platform, const HangingLoadState& state) const;
  PlatformWrench CalcWrench(const Rope& rope, const PlatformWrench& others) const;
  HangingLoadState CalcRate(const HangingLoadState& state, const Rope& rope) const {
    return {state.v_W, -rope.force_W / params.mass - Vec<3>(0, 0, params.gravity)};
  }
  void CalcGeometry(const PlatformState& platform, const HangingLoadState& state, const Rope& rope,
                    Geometry* out) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::HangingLoadState);
