#pragma once

#include <tenon/plants/signals/leash_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>
#include <tenon/systems/geometry.h>

#include <array>
#include <utility>
#include <vector>

namespace tenon {

enum class Activity {
  kFollow,  ///< walks with a speed where the leash leads, if it is taut
  kWalk,    ///< walks with a speed in a direction; with none stands
  kPull,    ///< leans with a force in a direction
};
constexpr auto EnumNames(Activity) {
  return std::array{Named{Activity::kFollow, "follow"}, Named{Activity::kWalk, "walk"},
                    Named{Activity::kPull, "pull"}};
}

/// What a person does for a while. The speed is speed + speed_amplitude sin(angular_frequency t), t counting
/// from the beginning of the phase.
struct PersonPhase {
  Activity activity = Activity::kWalk;  ///< what the person does
  double duration = 0;                  ///< how long [s]
  double speed = 0;                     ///< of following and walking, its mean [m/s]
  double speed_amplitude = 0;           ///< of a sine about that, at most as large [m/s]
  double angular_frequency = 0;         ///< of that sine [rad/s]
  double direction = 0;                 ///< of walking and pulling, in W, from x towards y [rad]
  double force = 0;                     ///< of pulling [N]

  static FieldList Fields() {
    return {Required("activity", &PersonPhase::activity),
            Required("duration_s", &PersonPhase::duration),
            {"speed_m_per_s", &PersonPhase::speed},
            {"speed_amplitude_m_per_s", &PersonPhase::speed_amplitude},
            {"angular_frequency_rad_per_s", &PersonPhase::angular_frequency},
            {"direction_rad", &PersonPhase::direction},
            {"force_N", &PersonPhase::force}};
  }
};

/// Defaults: an adult who walks slowly and gives way by 5 cm to 30 N, see docs/guide_dog.md.
struct PersonParams {
  double mass = 70;                 ///< m [kg]
  double damping = 420;             ///< C [N s/m]
  double stiffness = 630;           ///< K [N/m]
  double felt_tension = 5;          ///< of the leash, from which the person follows at full speed [N]
  double hand_height = 0.75;        ///< where the hand holds the leash, over the ground [m]
  Vec<2> start = Vec<2>::Zero();    ///< where the person stands at the start, in W [m]
  std::vector<PersonPhase> phases;  ///< one after the other, from t = 0 on; then stands
  Rate rate = Hz(100);              ///< at which the person changes intent

  static FieldList Fields() {
    return {{"mass_kg", &PersonParams::mass},
            {"damping_N_s_per_m", &PersonParams::damping},
            {"stiffness_N_per_m", &PersonParams::stiffness},
            {"felt_tension_N", &PersonParams::felt_tension},
            {"hand_height_m", &PersonParams::hand_height},
            {"start_m", &PersonParams::start},
            Required("phases", &PersonParams::phases),
            Undescribed(&PersonParams::rate)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// What the person is about at present.
struct PersonIntent {
  Activity activity = Activity::kWalk;
  double speed = 0;                     ///< [m/s]
  Vec<2> direction_W = Vec<2>::Zero();  ///< unit vector, unless following
  double force = 0;                     ///< [N]

  static FieldList Fields() {
    return {{"activity", &PersonIntent::activity},
            {"speed", &PersonIntent::speed, "m/s"},
            {"direction_W", &PersonIntent::direction_W},
            {"force", &PersonIntent::force, "N"}};
  }
};

/// A place to which the person goes, instead of what the phases say.
struct PersonGoal {
  bool on = false;
  Vec<2> place = Vec<2>::Zero();  ///< [m]
  double speed = 0.5;             ///< at most [m/s]

  static FieldList Fields() {
    return {
        {"on", &PersonGoal::on}, {"place", &PersonGoal::place, "m"}, {"speed", &PersonGoal::speed, "m/s"}};
  }
};

/// Where the person is and wants to be.
struct PersonMotion {
  Vec<2> x = Vec<2>::Zero();       ///< [m]
  Vec<2> v = Vec<2>::Zero();       ///< [m/s]
  Vec<2> wanted = Vec<2>::Zero();  ///< w [m]

  static FieldList Fields() {
    return {
        {"x", &PersonMotion::x, "m"}, {"v", &PersonMotion::v, "m/s"}, {"wanted", &PersonMotion::wanted, "m"}};
  }
};

/// A person on a leash: a point that moves over ground, Morlando 2023, eq. (2.47) in the plane,
///
///     m v' + C v = f_ext + f,
///
/// f being the horizontal part of the leash's pull; the ground carries the rest and the weight.
/// The force f_ext with which the person pushes off the ground makes of it a mass, spring and damper about
/// the place w where the person wants to be:
///
///     f_ext = C u + K (w - x),   w' = u,                 when walking with the wanted velocity u,
///     f_ext = F d,               w' = v + K/C (x - w),   when pulling with the force F in direction d.
///
/// So a person who is led gives way to the leash, K^-1 f, but keeps the wanted speed in the mean; and who
/// pulls forgets about the place. Following, u points where the leash leads over ground and has the wanted
/// speed, less below felt_tension, |u| = speed min(1, T / felt_tension): nobody follows a slack leash.
///
///     ports in   leash     pulls the hand by tension * direction
///     ports out  person    position, velocity, hand
///                intent    sampled
///                geometry  a body, its path over ground
///     parameters mass [kg], damping [N s/m], stiffness [N/m], felt_tension [N]
///                phases    list of PersonPhase
///                goal      a place to go to instead: straight there, slower within the last 1 s
///
/// The person has no width and walks through the robot.
class Person final : public LeafSystem<PersonParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<LeashState> leash{this, {"leash"}};
  Parameter<double> mass{this, {"mass", "kg"}, params.mass, "of the body, m"};
  Parameter<double> damping{this, {"damping", "N s/m"}, params.damping, "of the motion over ground, C"};
  Parameter<double> stiffness{
      this, {"stiffness", "N/m"}, params.stiffness, "with which the person holds the wanted place, K"};
  Parameter<double> felt_tension{this,
                                 {"felt_tension", "N"},
                                 params.felt_tension,
                                 "of the leash, from which the person follows at full speed"};
  Parameter<std::vector<PersonPhase>> phases{
      this, {"phases"}, params.phases, "what the person does from t = 0 on, one after the other"};
  Parameter<PersonGoal> goal{this, {"goal"}, PersonGoal{}, "a place to go to, instead of the phases"};
  ContinuousState<PersonMotion> motion{this, {"motion"}, {params.start, Vec<2>::Zero(), params.start}};
  OutputPort<PersonIntent> intent{
      this, {"intent"}, Sampled{params.rate}, Uses(time, phases, goal, motion), &Person::CalcIntent};
  TimeDerivative<PersonMotion> dmotion{
      motion, Uses(motion, intent, leash, mass, damping, stiffness, felt_tension), &Person::CalcDerivative};
  OutputPort<PersonState> person{this, {"person"}, Uses(motion), &Person::CalcPerson};
  OutputPort<Geometry> geometry{this, {"geometry"}, MakeGeometry(), Uses(motion), &Person::CalcGeometry};

 private:
  PersonIntent CalcIntent(double time, const std::vector<PersonPhase>& phases, const PersonGoal& goal,
                          const PersonMotion& motion) const;
  PersonMotion CalcDerivative(const PersonMotion& motion, const PersonIntent& intent, const LeashState& leash,
                              double mass, double damping, double stiffness, double felt_tension) const;
  PersonState CalcPerson(const PersonMotion& motion) const;
  void CalcGeometry(const PersonMotion& motion, Geometry* geometry) const;
  static Geometry MakeGeometry();
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::PersonMotion);
TENON_DECLARE_SIGNAL(tenon::PersonIntent);
TENON_DECLARE_SIGNAL(tenon::PersonGoal);
