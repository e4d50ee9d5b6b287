#pragma once

#include <tenon/controllers/legged/planning/foothold_plan.h>
#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/planar_spline.h>
#include <tenon/controllers/legged/planning/step_properties.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct SwingPlannerParams {
  QuadrupedDescription robot;
  StepProperties step;
  /// CoM velocity error beyond which footholds capture the robot [m/s]
  double capture_speed = std::numeric_limits<double>::infinity();
  double gravity = kGravity;  ///< [m/s^2]
  Rate rate = Hz(1000);
  void Validate() const { CheckGravity(gravity); }  ///< throws ParameterError
};

/// Plans footholds and the motion of the feet in the air (Morlando 2023, section 2.4.1).
///
/// `body` counts with its velocity, `wrench` is the estimated one for wrench_shift, and `planned` has
/// footholds of CentroidalMpc that replace those below. Without `foot_forces` there is no reflex.
/// `footholds` are the next one of a swing foot and the present one of a stance foot.
///
/// **Foothold.** The foothold is chosen at lift-off and updated horizontally at every tick until
/// retarget_phase. It is the nominal place below the path in the middle of the coming stance, plus k d with
/// the horizontal velocity error d of a CoM fixed to the trunk, plus the shift
///
///     s max(0, 1 - (d / |s|)^2),    s = ((h f_x + t_y) / N, (h f_y - t_x) / N),    N = max(m g - f_z, m g /
///     2),
///
/// where s is the displacement of the ground reaction that balances the wrench (f, t) on a CoM at height h,
/// low-pass filtered and limited. The dead band d = free_shift leaves small wrenches to the whole-body
/// controller, since moving footholds disturb the walk more than they do.
///
/// The part of d beyond `capture_speed` displaces the foothold by sqrt(h / g) instead of k: to the capture
/// point, where the inverted pendulum of height h comes to rest (Pratt et al., Capture point, Humanoids
/// 2006). It does not apply to a robot that ropes hold, which is no pendulum on its feet.
///
/// A `known_wrench` (f, t), such as that of ropes, displaces the nominal places below the path by d, so that
/// the ground reaction m g e_z - f on a plane of slope s balances it:
///
///     ((m g - f_z) I + f_xy s^T) d = (h f_x + t_y, h f_y - t_x).
///
/// If f is the negative of the weight's component along the slope, the reaction is normal to the plane, and
/// the centre of the feet is below the CoM along that normal instead of along gravity.
///
/// Footholds follow the robot rather than the path if it is displaced or turned, which would bring footholds
/// below the path out of reach: the errors of CoM and heading beyond free_offset and free_turn are added to
/// the path. Finally the foothold is limited to the reach of the leg around its nominal place at touchdown.
/// Its height is that of the ground plane at lift-off.
///
/// **Swing.** A swing starts at the measured position. The horizontal motion is a polynomial of degree five
/// from rest to rest; a new foothold continues it with its present velocity and acceleration. The height
/// above the ground's slope consists of two such polynomials, up and down, each over half of the swing, with
/// equal acceleration at the junction. The foot arrives with touchdown_speed v downwards. A late or searching
/// foot continues as
///
///     z = z_0 - D (1 - e^(-v t / D)),
///
/// bounded by the search depth D. The acceleration is continuous throughout the swing except at a reflex and
/// where a foot chooses its level anew.
///
/// **Step reflex** (after Focchi et al., Local reflex generation for obstacle negotiation in quadrupedal
/// locomotion, CLAWAR 2013). A foot that hits the side of a block is held down by the friction of its own
/// push. If a swing foot deviates horizontally by more than `lag` and a force above `force` pushes it in the
/// direction of its deviation, it aborts the step: it moves back by `retreat` and lands. Its next step is at
/// least `height` high and moves straight up until rise_phase. There is no reflex in that next step and
/// beyond retarget_phase. (FootScheduler ends the step at the force from early_touchdown_phase on.) Both
/// conditions are required: a foot that deviates without a force belongs to a tipping trunk and must reach
/// its foothold.
///
/// **Elevation map.** With a map, a foothold near an edge moves to a flatter place that is free of the other
/// feet (see FlatPlace), on the level that was chosen at lift-off, or at the first foothold of CentroidalMpc
/// after it, and has the height of the map there. The top of the swing is `height` above the highest point of
/// the map between lift-off and foothold. A foot that must climb first moves straight up until
/// reflex.rise_phase; one that must descend moves straight down for as long at the end.
///
/// **Reach.** The distance of a swing foot from its hip is limited to that of a leg with a bent knee, since a
/// straight leg would snap through its singularity. The foot is moved horizontally, at constant height.
class SwingPlanner final : public LeafSystem<SwingPlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

  /// Motion of a leg since its last event.
  struct LegMemory {
    ContactState state = ContactState::kStance;
    PlanarPoint from;                  ///< start of the horizontal motion to the foothold
    double from_time = 0;              ///< time of `from` after lift-off [s]
    double time = 0;                   ///< time after lift-off, at the last tick [s]
    Vec<3> lift_off = Vec<3>::Zero();  ///< position at lift-off [m]
    GroundPlane ground;                ///< ground plane at lift-off, raised to the feet's centres
    double highest = 0;                ///< height of a foot on the highest point of the way, with a map [m]
    double rise = 0;                   ///< phase of the swing until which the foot moves straight up
    double sink = 0;                   ///< last part of the swing, in which it moves straight down
    Vec<3> foothold = Vec<3>::Zero();  ///< next foothold, or position in stance [m]
    Vec<3> hip = Vec<3>::Zero();       ///< position of the hip [m]
    double searching = 0;              ///< time in the states late and searching [s]
    bool blocked = false;  ///< the reflex triggered in this swing, or in the last one of a stance foot
    bool high = false;     ///< this swing follows one with a reflex
    bool awaits = false;   ///< `planned` has kept the foothold of a foot that stands
    Vec<2> planned = Vec<2>::Zero();  ///< its foothold when the foot last stood [m]

    static FieldList Fields() {
      return {{"state", &LegMemory::state},
              {"from", &LegMemory::from},
              {"from_time", &LegMemory::from_time, "s"},
              {"time", &LegMemory::time, "s"},
              {"lift_off", &LegMemory::lift_off, "m"},
              {"ground", &LegMemory::ground},
              {"highest", &LegMemory::highest, "m"},
              {"rise", &LegMemory::rise},
              {"sink", &LegMemory::sink},
              {"foothold", &LegMemory::foothold, "m"},
              {"hip", &LegMemory::hip, "m"},
              {"searching", &LegMemory::searching, "s"},
              {"blocked", &LegMemory::blocked},
              {"high", &LegMemory::high},
              {"awaits", &LegMemory::awaits},
              {"planned", &LegMemory::planned, "m"}};
    }
  };
  struct Memory {
    bool started = false;
    Vec<2> shift = Vec<2>::Zero();  ///< filtered shift of the footholds [m]
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
  InputPort<WrenchEstimate> known_wrench{this, {"known_wrench"}, WrenchEstimate()};
  InputPort<FootholdPlan> planned{this, {"planned"}, FootholdPlan()};
  InputPort<ElevationMap> map{this, {"map"}, ElevationMap()};
  InputPort<double> clock_rate{this, {"clock_rate"}, 1};
  Parameter<StepProperties> step{
      this, {"step"}, params.step, "shape of the steps and choice of the footholds"};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<Memory> plan{this,
                          {"plan"},
                          Sampled{params.rate},
                          Uses(schedule, path, body, state, ground, foot_forces, wrench, known_wrench,
                               planned, map, step, memory),
                          &SwingPlanner::CalcPlan};
  OutputPort<FeetReference> feet{
      this, {"feet"}, Sampled{params.rate}, Uses(schedule, plan, clock_rate, step), &SwingPlanner::CalcFeet};
  OutputPort<std::array<Vec<3>, kNumLegs>> footholds{
      this, {"footholds", "m", kLegElements}, Sampled{params.rate}, Uses(plan), &SwingPlanner::CalcFootholds};

 private:
  void CalcPlan(const ContactSchedule& schedule, const PlanarPath& path, const BodyReference& body,
                const LeggedState& state, const GroundPlane& ground, const FootForces& foot_forces,
                const WrenchEstimate& wrench, const WrenchEstimate& known_wrench, const FootholdPlan& planned,
                const ElevationMap& map, const StepProperties& step, Memory& memory, Memory* plan) const;
  FeetReference CalcFeet(const ContactSchedule& schedule, const Memory& plan, double clock_rate,
                         const StepProperties& step) const;
  std::array<Vec<3>, kNumLegs> CalcFootholds(const Memory& plan) const;

  Eigen::Vector2d PushedBack(std::size_t leg, const ContactSchedule& schedule, const LegMemory& memory,
                             const Vec<3>& foot, const Vec<3>& force, const StepProperties& step) const;
  void PlaceOnMap(const ElevationMap& map, bool decides, std::span<const Vec<3>> others,
                  const StepProperties& step, LegMemory* leg) const;
  Eigen::Vector2d Feedback(const Eigen::Vector2d& v_error, const WrenchEstimate& known_wrench,
                           const StepProperties& step) const;
  Eigen::Vector2d Shift(const WrenchEstimate& wrench, const StepProperties& step) const;
  Eigen::Vector2d Displacement(const WrenchEstimate& known_wrench, const Vec<2>& slope) const;
  Eigen::Vector2d Foothold(std::size_t leg, const ContactSchedule& schedule, const PlanarPath& path,
                           const Eigen::Vector2d& slope, const Eigen::Vector2d& correction) const;
  PlanarPath BelowTheRobot(const PlanarPath& path, const BodyReference& body, const LeggedState& state,
                           const StepProperties& step) const;

  const double weight_ = params.robot.mass() * params.gravity;
};

}  // namespace tenon
