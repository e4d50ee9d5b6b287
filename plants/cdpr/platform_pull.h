#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct PlatformPullParams {
  double stiffness = 0;  ///< k [N/m]
  double damping = 0;    ///< d [N s/m]
  double max_force = 0;  ///< [N]

  static FieldList Fields() {
    using P = PlatformPullParams;
    return {Undescribed("stiffness", &P::stiffness).AtLeast(0),
            Undescribed("damping", &P::damping).AtLeast(0),
            Undescribed("max_force", &P::max_force).AtLeast(0)};
  }
};

/// Grip point and target of a PlatformPull.
struct PlatformGrip {
  bool on = false;
  Vec<3> p_B = Vec<3>::Zero();       ///< the point, from the CoM in the platform's axes [m]
  Vec<3> target_W = Vec<3>::Zero();  ///< [m]

  static FieldList Fields() {
    return {{"on", &PlatformGrip::on},
            {"p_B", &PlatformGrip::p_B, "m"},
            {"target_W", &PlatformGrip::target_W, "m"}};
  }
};

/// A spring and a damper that pull the point p = p_WB + R_WB p_B of a platform towards a target, with the
/// force saturated at F_max:
///
///     F = k (target - p) - d v,   v = v_WB + w x (p - p_WB),   |F| <= F_max,
///
/// The output is its wrench about the CoM plus `others`. If `on` is false, the force is zero.
class PlatformPull final : public LeafSystem<PlatformPullParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<PlatformState> platform{this, {"platform"}};
  InputPort<PlatformWrench> others{this, {"others"}, PlatformWrench{}};
  Parameter<PlatformGrip> grip{
      this, {"grip"}, PlatformGrip{}, "point that is held, and the target it is pulled to"};
  OutputPort<PlatformWrench> wrench{
      this, {"wrench"}, Uses(platform, others, grip), &PlatformPull::CalcWrench};

  /// The force F [N].
  Vec<3> Force(const PlatformState& platform, const PlatformGrip& grip) const;

 private:
  PlatformWrench CalcWrench(const PlatformState& platform, const PlatformWrench& others,
                            const PlatformGrip& grip) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::PlatformGrip);
