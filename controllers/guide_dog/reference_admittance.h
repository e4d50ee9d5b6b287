#pragma once

#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Gains of ReferenceAdmittance along the axes of the heading: forward, left, up. The stiffness keeps the
/// feet within reach: at rest, the difference of f_d moves the reference by 3 cm.
struct ReferenceAdmittanceGains {
  Vec<3> desired_force{30, 0, 0};      ///< f_d, with which the robot is to pull the leash [N]
  Vec<3> mass{8, 8, 8};                ///< diagonal of M_a [kg]
  Vec<3> damping{180, 180, 180};       ///< diagonal of D_a, about critical [N s/m]
  Vec<3> stiffness{1000, 1000, 1000};  ///< diagonal of K_a [N/m]

  static FieldList Fields() {
    using G = ReferenceAdmittanceGains;
    return {{"desired_force_N", &G::desired_force},
            Field("mass_kg", &G::mass).Positive().Uniform(),
            Field("damping_N_s_per_m", &G::damping).Positive().Uniform(),
            Field("stiffness_N_per_m", &G::stiffness).AtLeast(0).Uniform()};
  }
};

/// The admittance of Morlando 2023, eq. (2.49), as it is printed, on the reference position of the CoM and
/// behind the planner, in contrast to AdmittanceFilter, which changes the commanded velocity:
///
///     M_a x~'' + D_a x~' + K_a x~ = f_d + f,   x_mod = x_ref + x~,
///
/// with diagonal matrices in the frame of the heading and the estimated force f on the robot. A taut leash
/// pulls the robot back, f = -T e, so the robot lags behind its plan while the tension T exceeds f_d, and
/// leads it while T is smaller. The planner and the footholds do not know x~: it must stay small, and a
/// person who is slower than the commanded speed stretches the leash without bound. The state `x` is x~ and
/// x~', forward, left and up.
///
/// Insert it with `builder.Insert(loop.locomotion.com_planner.reference, admittance.body,
/// admittance.modified)`.
class ReferenceAdmittance final : public LeafSystem<ReferenceAdmittanceGains> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<BodyReference> body{this, {"body"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  Parameter<ReferenceAdmittanceGains> gains{this, {"gains"}, params, "desired force and admittance"};
  ContinuousState<Vec<6>> x{this, {"x", "m, m, m, m/s, m/s, m/s"}};
  TimeDerivative<Vec<6>> dx{x, Uses(x, body, wrench, gains), &ReferenceAdmittance::CalcRate};
  OutputPort<BodyReference> modified{
      this, {"modified"}, Uses(x, body, wrench, gains), &ReferenceAdmittance::CalcModified};

 private:
  Vec<6> CalcRate(const Vec<6>& x, const BodyReference& body, const WrenchEstimate& wrench,
                  const ReferenceAdmittanceGains& gains) const;
  BodyReference CalcModified(const Vec<6>& x, const BodyReference& body, const WrenchEstimate& wrench,
                             const ReferenceAdmittanceGains& gains) const;
};

}  // namespace tenon
