#pragma once

#include <tenon/plants/signals/leash_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/geometry.h>

namespace tenon {

enum class Activity {
  kFollow,  ///< walks along the taut leash at a given speed
  kWalk,    ///< walks in a given direction; stands at speed 0
  kPull,    ///< pulls with a given force in a given direction
};

/// Phase of a person's motion. The speed is speed + speed_amplitude sin(angular_frequency t), with t from the
/// start of the phase.
struct PersonPhase {
  Activity activity = Activity::kWalk;  ///< activity of the person in the phase
  double duration = 0;                  ///< duration of the phase [s]
  double speed = 0;                     ///< mean speed of a person who follows or walks [m/s]
  double speed_amplitude = 0;           ///< amplitude of the speed, at most `speed` [m/s]
  double angular_frequency = 0;         ///< angular frequency of the speed's variation [rad/s]
  double direction = 0;  ///< direction in W in which the person walks or pulls, from x towards y [rad]
  double force = 0;      ///< force with which the person pulls [N]

  static FieldList Fields() {
    return {Required("activity", &PersonPhase::activity),
            Required("duration_s", &PersonPhase::duration).Positive().OrInfinite(),
            Field("speed_m_per_s", &PersonPhase::speed).Finite(),
            {"speed_amplitude_m_per_s", &PersonPhase::speed_amplitude},
            Field("angular_frequency_rad_per_s", &PersonPhase::angular_frequency).Finite(),
            Field("direction_rad", &PersonPhase::direction).Finite(),
            Field("force_N", &PersonPhase::force).AtLeast(0).Because("give another direction_rad")};
  }
};

/// Parameters of Person. The defaults model an adult who walks slowly and yields by 5 cm to a force of 30 N,
/// see docs/guide_dog.md.
struct PersonParams {
  double mass = 70;                 ///< mass m of the person [kg]
  double damping = 420;             ///< damping C of the person's motion [N s/m]
  double stiffness = 630;           ///< stiffness K of the person's stance [N/m]
  double felt_tension = 5;          ///< tension of the leash at which the person follows at full speed [N]
  double acceleration = 0;          ///< largest acceleration of the wanted speed; 0: any [m/s^2]
  double hand_height = 0.75;        ///< height of the hand above the ground [m]
  Vec<2> start = Vec<2>::Zero();    ///< initial position in W [m]
  std::vector<PersonPhase> phases;  ///< consecutive phases from t = 0; afterwards the person stands
  Rate rate = Hz(100);              ///< rate at which the intent is updated

  static FieldList Fields() {
    return {Field("mass_kg", &PersonParams::mass).Positive(),
            Field("damping_N_s_per_m", &PersonParams::damping).Positive(),
            Field("stiffness_N_per_m", &PersonParams::stiffness).AtLeast(0),
            Field("felt_tension_N", &PersonParams::felt_tension).Positive(),
            Field("acceleration_m_per_s2", &PersonParams::acceleration).AtLeast(0),
            Field("hand_height_m", &PersonParams::hand_height).AtLeast(0),
            Field("start_m", &PersonParams::start).Finite(),
            Required("phases", &PersonParams::phases),
            Undescribed(&PersonParams::rate)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Present intent of a person.
struct PersonIntent {
  Activity activity = Activity::kWalk;  ///< activity of the person in the phase
  double speed = 0;                     ///< [m/s]
  Vec<2> direction_W = Vec<2>::Zero();  ///< unit vector; 0 for kFollow
  double force = 0;                     ///< [N]

  static FieldList Fields() {
    return {{"activity", &PersonIntent::activity},
            {"speed", &PersonIntent::speed, "m/s"},
            {"direction_W", &PersonIntent::direction_W},
            {"force", &PersonIntent::force, "N"}};
  }
};

/// Destination that overrides the phases.
struct PersonGoal {
  bool on = false;
  Vec<2> place = Vec<2>::Zero();  ///< [m]
  double speed = 0.5;             ///< largest speed [m/s]

  static FieldList Fields() {
    return {
        {"on", &PersonGoal::on}, {"place", &PersonGoal::place, "m"}, {"speed", &PersonGoal::speed, "m/s"}};
  }
};

/// Position of the person and of its equilibrium.
struct PersonMotion {
  Vec<2> x = Vec<2>::Zero();       ///< [m]
  Vec<2> v = Vec<2>::Zero();       ///< [m/s]
  Vec<2> wanted = Vec<2>::Zero();  ///< w, equilibrium position [m]

  static FieldList Fields() {
    return {
        {"x", &PersonMotion::x, "m"}, {"v", &PersonMotion::v, "m/s"}, {"wanted", &PersonMotion::wanted, "m"}};
  }
};

/// A person on a leash, as a point that moves in the plane (Morlando 2023, eq. (2.47)):
///
///     m v' + C v = f_ext + f,
///
/// with the horizontal part f of the leash's force; the ground carries its vertical part and the weight. The
/// ground reaction f_ext of the person yields a mass, spring and damper about the equilibrium position w:
///
///     f_ext = C u + K (w - x),   w' = u,                 when walking with the wanted velocity u,
///     f_ext = F d,               w' = v + K/C (x - w),   when pulling with the force F in direction d.
///
/// A person who walks yields to the leash by f / K and keeps the desired mean speed; the equilibrium of a
/// person who pulls moves along. For kFollow, u has the horizontal direction of the leash and the desired
/// speed, reduced below felt_tension: |u| = speed min(1, T / felt_tension), 0 if T <= 0.
/// With an `acceleration` above 0, u changes at most at that rate, in steps at the ticks, whatever the
/// intent.
///
/// The force on the hand is tension * direction of `leash`, `velocity` is u, and `goal` overrides the phases,
/// with a deceleration in the last second.
///
/// The person is a point and exerts no force on a robot that runs into it; tenon-guide-dog reports such
/// collisions with the upright capsule of kRadius and kHeight that is drawn.
class Person final : public LeafSystem<PersonParams> {
 public:
  static constexpr double kRadius = 0.15, kHeight = 1.5;  ///< of the body, without the head [m]

  using LeafSystem::LeafSystem;

  InputPort<LeashState> leash{this, {"leash"}};
  Parameter<double> mass{this, {"mass", "kg"}, params.mass, "mass m of the body"};
  Parameter<double> damping{
      this, {"damping", "N s/m"}, params.damping, "damping C of the motion over ground"};
  Parameter<double> stiffness{
      this, {"stiffness", "N/m"}, params.stiffness, "stiffness K towards the equilibrium position"};
  Parameter<double> felt_tension{this,
                                 {"felt_tension", "N"},
                                 params.felt_tension,
                                 "tension of the leash at which the person follows at full speed"};
  Parameter<std::vector<PersonPhase>> phases{
      this, {"phases"}, params.phases, "consecutive phases from t = 0"};
  Parameter<double> acceleration{this,
                                 {"acceleration", "m/s^2"},
                                 params.acceleration,
                                 "largest acceleration of the wanted speed; 0: any"};
  Parameter<PersonGoal> goal{this, {"goal"}, PersonGoal{}, "destination that overrides the phases"};
  ContinuousState<PersonMotion> motion{this, {"motion"}, {params.start, Vec<2>::Zero(), params.start}};
  OutputPort<PersonIntent> intent{
      this, {"intent"}, Sampled{params.rate}, Uses(time, phases, goal, motion), &Person::CalcIntent};
  Scratch<Vec<2>> last_velocity{this, "last_velocity", Vec<2>(0, 0)};
  OutputPort<Vec<2>> velocity{this,
                              {"velocity", "m/s"},
                              Sampled{params.rate},
                              Uses(intent, acceleration, motion, leash, felt_tension, last_velocity),
                              &Person::CalcVelocity};
  TimeDerivative<PersonMotion> dmotion{
      motion, Uses(motion, intent, velocity, acceleration, leash, mass, damping, stiffness, felt_tension),
      &Person::CalcDerivative};
  OutputPort<PersonState> person{this, {"person"}, Uses(motion), &Person::CalcPerson};
  OutputPort<Geometry> geometry{this, {"geometry"}, MakeGeometry(), Uses(motion), &Person::CalcGeometry};

 private:
  PersonIntent CalcIntent(double time, const std::vector<PersonPhase>& phases, const PersonGoal& goal,
                          const PersonMotion& motion) const;
  Vec<2> CalcVelocity(const PersonIntent& intent, double acceleration, const PersonMotion& motion,
                      const LeashState& leash, double felt_tension, Vec<2>& last_velocity) const;
  PersonMotion CalcDerivative(const PersonMotion& motion, const PersonIntent& intent, const Vec<2>& velocity,
                              double acceleration, const LeashState& leash, double mass, double damping,
                              double stiffness, double felt_tension) const;
  PersonState CalcPerson(const PersonMotion& motion) const;
  void CalcGeometry(const PersonMotion& motion, Geometry* geometry) const;
  static Geometry MakeGeometry();
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::PersonMotion);
TENON_DECLARE_SIGNAL(tenon::PersonIntent);
TENON_DECLARE_SIGNAL(tenon::PersonGoal);
