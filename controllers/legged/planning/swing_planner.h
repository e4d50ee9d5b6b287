#pragma once

#include <array>

#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/planar_point.h>
#include <tenon/plants/model/disturbance_signals.h>
#include <tenon/plants/model/gait_signals.h>
#include <tenon/plants/model/gravity.h>
#include <tenon/plants/model/ground_plane.h>
#include <tenon/plants/model/legged_signals.h>
#include <tenon/plants/model/motion_signals.h>
#include <tenon/systems/framework/parameter.h>
#include <tenon/systems/framework/state.h>
#include <tenon/systems/framework/system.h>

namespace tenon {

/// The step reflex of a robot that does not see the ground: what a swing foot does that has met the side of
/// something.
struct StepReflex {
  bool enabled = true;      ///< a foot that meets the side of something gives its step up
  double lag = 0.03;        ///< a foot has met something that is farther behind its course over ground [m]
  double force = 0.05;      ///< while this pushes it back, over the robot's weight m g
  double retreat = 0.02;    ///< before it lands, so far it goes back from there [m]
  double height = 0.1;      ///< of its next step, as StepProperties::height [m]
  double rise_phase = 0.3;  ///< part of that swing in which it only rises

  static FieldList Fields() {
    return {{"enabled", &StepReflex::enabled}, {"lag_m", &StepReflex::lag},
            {"force_mg", &StepReflex::force},  {"retreat_m", &StepReflex::retreat},
            {"height_m", &StepReflex::height}, {"rise_phase", &StepReflex::rise_phase}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// What a user chooses of the steps.
struct StepProperties {
  double height = 0.05;             ///< of the feet over the higher of take-off and foothold [m]
  double touchdown_speed = 0.5;     ///< downwards, planned; a late foot gets 9 cm deeper in 0.25 s [m/s]
  double search_depth = 0.2;        ///< how far below its foothold a foot searches at most [m]
  double velocity_feedback = 0.03;  ///< of the foothold, per CoM velocity error [s]
  double retarget_phase = 0.7;      ///< part of the swing in which the foothold is chosen anew at every tick
  bool wrench_shift = true;         ///< moves the footholds against the estimated wrench
  double free_shift = 0.08;         ///< what calls for less than this moves nothing [m]
  double shift_bandwidth = 16;      ///< of its low-pass filter [rad/s]
  double free_offset = 0.03;        ///< a CoM that is farther off takes its feet along [m]
  double free_turn = 0.1;           ///< and so does a trunk that is turned more [rad]
  double largest_shift = 0.1;       ///< of a foothold by the wrench, at most [m]
  StepReflex reflex = {};

  static FieldList Fields() {
    return {{"height_m", &StepProperties::height},
            {"touchdown_speed_m_per_s", &StepProperties::touchdown_speed},
            {"search_depth_m", &StepProperties::search_depth},
            {"velocity_feedback_s", &StepProperties::velocity_feedback},
            {"retarget_phase", &StepProperties::retarget_phase},
            {"wrench_shift", &StepProperties::wrench_shift},
            {"free_shift_m", &StepProperties::free_shift},
            {"shift_bandwidth_rad_per_s", &StepProperties::shift_bandwidth},
            {"largest_shift_m", &StepProperties::largest_shift},
            {"free_offset_m", &StepProperties::free_offset},
            {"free_turn_rad", &StepProperties::free_turn},
            {"reflex", &StepProperties::reflex}};
  }
  void Validate() const;  ///< throws ParameterError
};

struct SwingPlannerParams {
  QuadrupedDescription robot;
  StepProperties step;
  double gravity = kGravity;  ///< [m/s^2]
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Plans footholds and the motion of the feet in the air (Morlando 2023, section 2.4.1).
///
///     ports in   schedule   which feet stand; phases of those that swing
///                path       of the CoM planner, with its twist
///                body       the CoM planner's reference, for the velocity error
///                state      where the feet are
///                ground     below the robot
///                foot_forces  measured, of the ground on each foot [N], for the reflex; none if not
///                connected wrench     estimated disturbance, for the option wrench_shift; none if not
///                connected
///     parameter  step       StepProperties
///     ports out  feet       position, velocity, acceleration of all feet; sampled
///                footholds  next place of a foot in the air, present place of one that stands [m]; sampled
///
/// **Foothold.** Chosen at lift-off, and over ground anew at every tick until retarget_phase, so that in the
/// middle of its coming stance the foot is at its nominal place below the path, plus k (v - v_ref) with the
/// horizontal velocity of a CoM fixed to the trunk, plus the shift
///
///     s max(0, 1 - (d / |s|)^2),    s = ((h f_x + t_y) / N, (h f_y - t_x) / N),    N = m g - f_z,
///
/// where s is where the ground's reaction must go to balance the wrench (f, t) on a CoM at height h; low-pass
/// filtered and limited. Below d = free_shift the feet stay: the trunk takes up what is small, and feet that
/// move for every push disturb the walk more than it does.
///
/// Feet belong below the robot. Where friction does not hold it on its path, it is pushed along or turned,
/// and feet that were planted below the path all the same would be out of its legs' reach: beyond free_offset
/// and free_turn, the errors of CoM and heading move the path below which the feet are planted. Then drawn
/// into the reach of the leg, seen from its nominal place at touchdown. Its height is that of the ground as
/// it is felt at lift-off.
///
/// **Swing.** From the measured place at lift-off. Over ground a polynomial of degree five from rest to rest,
/// which a new foothold replaces by the one that goes on from where the old has come, with its velocity and
/// acceleration; in height over the ground's slope two, each half of the swing long: lift and lower, joined
/// with equal acceleration.
/// It arrives with a small speed downwards. A foot that is late, or searches, goes on from there,
///
///     z = z_0 - D (1 - e^(-v t / D)),
///
/// bounded by the search depth D. Throughout the swing the acceleration does not jump.
///
/// **Step reflex** (after Focchi et al., Local reflex generation for obstacle negotiation in quadrupedal
/// locomotion, CLAWAR 2013). A foot that meets the side of a block is held down by the friction of its own
/// push, and would stay there from step to step while the robot walks on. So one that lags behind its course
/// over ground by more than `lag`, and is pushed back by more than `force`, gives this step up: it goes back
/// by `retreat` and lands. Its next step is `height` high, and goes straight up first, until rise_phase.
/// During that step there is no reflex.
///
/// In the air no foot is sent farther from its hip than a leg with a bent knee reaches, wherever the trunk
/// is: through a straight one the knee would snap to the other side, and there is no force to get it back.
/// It is drawn in at its height.
class SwingPlanner final : public LeafSystem<SwingPlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

  /// One leg's motion since its last event.
  struct LegMemory {
    ContactState state = ContactState::kStance;
    PlanarPoint from;                  ///< over ground, where the course to the foothold began,
    double from_time = 0;              ///< at this time after lift-off [s]
    Vec<3> lift_off = Vec<3>::Zero();  ///< where the foot left the ground [m]
    GroundPlane ground;                ///< then, at the feet's centres
    Vec<3> foothold = Vec<3>::Zero();  ///< or where it stands [m]
    Vec<3> hip = Vec<3>::Zero();       ///< [m]
    double searching = 0;              ///< for how long, late included [s]
    bool blocked = false;              ///< met something in this swing, or in the last one if it stands
    bool high = false;                 ///< this swing follows one in which it did

    static FieldList Fields() {
      return {{"state", &LegMemory::state},
              {"from", &LegMemory::from},
              {"from_time", &LegMemory::from_time, "s"},
              {"lift_off", &LegMemory::lift_off, "m"},
              {"ground", &LegMemory::ground},
              {"foothold", &LegMemory::foothold, "m"},
              {"hip", &LegMemory::hip, "m"},
              {"searching", &LegMemory::searching, "s"},
              {"blocked", &LegMemory::blocked},
              {"high", &LegMemory::high}};
    }
  };
  struct Memory {
    bool started = false;
    Vec<2> shift = Vec<2>::Zero();  ///< of the footholds [m]
    std::array<LegMemory, kNumLegs> legs;

    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"shift", &Memory::shift, "m"},
              {"legs", &Memory::legs, "", kLegElements}};
    }
  };

  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<PlanarPath> path{this, {"path"}};
  InputPort<BodyReference> body{this, {"body"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<GroundPlane> ground{this, {"ground"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}, FootForces()};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}, WrenchEstimate()};
  Parameter<StepProperties> step{this, {"step"}, params.step, "shape of the steps, choice of the footholds"};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<Memory> plan{this,
                          {"plan"},
                          Sampled{params.rate},
                          Uses(schedule, path, body, state, ground, foot_forces, wrench, step, memory),
                          &SwingPlanner::CalcPlan};
  OutputPort<FeetReference> feet{
      this, {"feet"}, Sampled{params.rate}, Uses(schedule, plan, step), &SwingPlanner::CalcFeet};
  OutputPort<std::array<Vec<3>, kNumLegs>> footholds{
      this, {"footholds", "m", kLegElements}, Sampled{params.rate}, Uses(plan), &SwingPlanner::CalcFootholds};

 private:
  void CalcPlan(const ContactSchedule& schedule, const PlanarPath& path, const BodyReference& body,
                const LeggedState& state, const GroundPlane& ground, const FootForces& foot_forces,
                const WrenchEstimate& wrench, const StepProperties& step, Memory& memory, Memory* plan) const;
  FeetReference CalcFeet(const ContactSchedule& schedule, const Memory& plan,
                         const StepProperties& step) const;
  std::array<Vec<3>, kNumLegs> CalcFootholds(const Memory& plan) const;

  Eigen::Vector2d Shift(const WrenchEstimate& wrench, const StepProperties& step) const;
  Eigen::Vector2d Foothold(std::size_t leg, const ContactSchedule& schedule, const PlanarPath& path,
                           const Eigen::Vector2d& slope, const Eigen::Vector2d& correction) const;
  PlanarPath BelowTheRobot(const PlanarPath& path, const BodyReference& body, const LeggedState& state,
                           const StepProperties& step) const;

  const double mass_ = params.robot.mass();
};

}  // namespace tenon
