#pragma once

#include <tenon/plants/signals/leash_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/geometry.h>

namespace tenon {

/// Defaults: a light elastic leash in a hanging arm, see docs/guide_dog.md.
struct LeashParams {
  double nominal_length = 1.5;         ///< l0, length above which the leash is taut [m]
  double stiffness = 200;              ///< stiffness of leash and arm in series [N/m]
  double dissipation = 0.33;           ///< damping coefficient over tension of a leash [s/m]
  bool handle = false;                 ///< a rigid handle, which also pushes, instead of a leash
  double damping_time = 0.05;          ///< damping of a handle and the arm over their stiffness [s]
  Vec<3> attachment_B{-0.25, 0, 0.1};  ///< attachment of the leash on the trunk, in B [m]

  static FieldList Fields() {
    return {Field("nominal_length_m", &LeashParams::nominal_length).Positive(),
            Field("stiffness_N_per_m", &LeashParams::stiffness).Positive(),
            Field("dissipation_s_per_m", &LeashParams::dissipation).AtLeast(0),
            {"handle", &LeashParams::handle},
            Field("damping_time_s", &LeashParams::damping_time).AtLeast(0),
            Field("attachment_m", &LeashParams::attachment_B).Finite()};
  }
};

/// A leash between a person's hand and a robot's trunk: a unilateral spring (Morlando 2023, eq. (2.48)) with
/// damping. With the elongation e = l - l0,
///
///     T = k e max(0, 1 + d e')   if e > 0, else 0.
///
/// The damping k e d grows with the tension, so T is continuous when the leash becomes taut. The leash has no
/// mass and does not sag. k is the stiffness of leash and arm in series.
///
/// The handle of a harness, with joints at both ends, also pushes, by the stiffness and the damping of the
/// arm:
///
///     T = k (e + tau e'),   negative if it pushes.
class Leash final : public LeafSystem<LeashParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> robot{this, {"robot"}};
  InputPort<PersonState> person{this, {"person"}};
  Parameter<double> nominal_length{this,
                                   {"nominal_length", "m"},
                                   params.nominal_length,
                                   "length above which the leash is taut, or of the handle without force"};
  Parameter<double> stiffness{
      this, {"stiffness", "N/m"}, params.stiffness, "stiffness of leash and arm in series"};
  Parameter<double> dissipation{
      this, {"dissipation", "s/m"}, params.dissipation, "damping coefficient over tension"};
  OutputPort<LeashState> leash{
      this, {"leash"}, Uses(robot, person, nominal_length, stiffness, dissipation), &Leash::CalcLeash};
  OutputPort<ExternalForce> force{this, {"force"}, Uses(leash), &Leash::CalcForce};
  OutputPort<Geometry> geometry{
      this, {"geometry"}, MakeGeometry(), Uses(person, leash), &Leash::CalcGeometry};

 private:
  LeashState CalcLeash(const LeggedState& robot, const PersonState& person, double nominal_length,
                       double stiffness, double dissipation) const;
  ExternalForce CalcForce(const LeashState& leash) const;
  void CalcGeometry(const PersonState& person, const LeashState& leash, Geometry* geometry) const;
  static Geometry MakeGeometry();
};

}  // namespace tenon
