#pragma once

#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/planar_point.h>
#include <tenon/controllers/legged/planning/step_properties.h>
#include <tenon/plants/model/gravity.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>

namespace tenon {

struct SwingPlannerParams {
  QuadrupedDescription robot;
  StepProperties step;
  double gravity = kGravity;  ///< [m/s^2]
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Plans footholds and the motion of the feet in the air (Morlando 2023, section 2.4.1).
///
///     ports in   schedule     which feet stand; phases of those that swing
///                path         of the CoM planner, with its twist
///                body         the CoM planner's reference, for the velocity error
///                state        where the feet are
///                ground       below the robot
///                foot_forces  measured, of the ground on each foot, in W [N]; no reflex if not connected
///                wrench       estimated disturbance, for wrench_shift; none if not connected
///     parameter  step         StepProperties
///     ports out  feet         position, velocity, acceleration of all feet; sampled
///                footholds    next place of a foot in the air, present one of one that stands [m]; sampled
///
/// **Foothold.** Chosen at lift-off, and over ground anew at every tick until retarget_phase, so that in the
/// middle of its coming stance the foot is at its nominal place below the path, plus k (v - v_ref) with the
/// horizontal velocity of a CoM fixed to the trunk, plus the shift
///
///     s max(0, 1 - (d / |s|)^2),    s = ((h f_x + t_y) / N, (h f_y - t_x) / N),    N = max(m g - f_z, m g /
///     2),
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
/// bounded by the search depth D. Throughout the swing the acceleration does not jump, but at a reflex.
///
/// **Step reflex** (after Focchi et al., Local reflex generation for obstacle negotiation in quadrupedal
/// locomotion, CLAWAR 2013). A foot that meets the side of a block is held down by the friction of its own
/// push, and would stay there from step to step while the robot walks on. So one that is farther off its
/// course over ground than `lag`, and is pushed away from it by more than `force`, gives this step up: it
/// goes back by `retreat` and lands. Its next step is at least `height` high, and goes straight up first,
/// until rise_phase; in that one there is no reflex, nor is there in any step beyond retarget_phase. (A
/// scheduler that takes every force for a touchdown from some phase on, as FootScheduler does, ends it
/// there.) Both conditions count: a foot that is off its course and free belongs to a trunk that tips, and
/// has to reach its foothold.
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
    double time = 0;                   ///< after lift-off, at the tick before [s]
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
              {"time", &LegMemory::time, "s"},
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

  Eigen::Vector2d PushedBack(std::size_t leg, const ContactSchedule& schedule, const LegMemory& memory,
                             const Vec<3>& foot, const Vec<3>& force, const StepProperties& step) const;
  Eigen::Vector2d Shift(const WrenchEstimate& wrench, const StepProperties& step) const;
  Eigen::Vector2d Foothold(std::size_t leg, const ContactSchedule& schedule, const PlanarPath& path,
                           const Eigen::Vector2d& slope, const Eigen::Vector2d& correction) const;
  PlanarPath BelowTheRobot(const PlanarPath& path, const BodyReference& body, const LeggedState& state,
                           const StepProperties& step) const;

  const double weight_ = params.robot.mass() * params.gravity;
};

}  // namespace tenon
