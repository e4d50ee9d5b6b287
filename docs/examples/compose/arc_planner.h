#pragma once

// A custom swing planner: the feet swing along arcs to their footholds below the path.

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

#include <array>

struct ArcPlannerParams {
  tenon::QuadrupedDescription robot;
  double height = 0.06;   ///< height of the arc [m]
  double lowering = 0.4;  ///< speed of a foot that has not found the ground [m/s]
  tenon::Rate rate = tenon::Hz(1000);
  void Validate() const { tenon::Demand(height > 0, "height must be positive"); }
};

/// Plans the motion of a foot from the point of lift-off (p_0) to its foothold (p_1), with the phase s of the
/// swing from 0 to 1:
///
///     p = p_0 + (p_1 - p_0) (3 s^2 - 2 s^3),   z = z_0 + 16 height s^2 (1 - s)^2
///
/// The foothold is the nominal position of the foot below the path in the middle of its next stance. A foot
/// without contact at the end of its swing is lowered.
class ArcPlanner final : public tenon::LeafSystem<ArcPlannerParams> {
 public:
  using LeafSystem::LeafSystem;

  struct Leg {
    tenon::Vec<3> from = tenon::Vec<3>::Zero();  ///< point of lift-off [m]
    tenon::Vec<2> to = tenon::Vec<2>::Zero();    ///< foothold [m]
    bool swings = false;
    double late = 0;  ///< time since the planned touchdown [s]
    static tenon::FieldList Fields() {
      return {{"from", &Leg::from, "m"},
              {"to", &Leg::to, "m"},
              {"swings", &Leg::swings},
              {"late", &Leg::late, "s"}};
    }
  };
  using Legs = std::array<Leg, tenon::kNumLegs>;

  tenon::InputPort<tenon::ContactSchedule> schedule{this, {"schedule"}};
  tenon::InputPort<tenon::PlanarPath> path{this, {"path"}};
  tenon::InputPort<tenon::LeggedState> state{this, {"state"}};
  tenon::Parameter<double> height{this, {"height", "m"}, params.height, "height of the arc"};
  tenon::Scratch<Legs> legs{this, "legs"};
  tenon::OutputPort<tenon::FeetReference> feet{this,
                                               {"feet"},
                                               tenon::Sampled{params.rate},
                                               tenon::Uses(schedule, path, state, height, legs),
                                               &ArcPlanner::CalcFeet};

 private:
  tenon::FeetReference CalcFeet(const tenon::ContactSchedule& schedule, const tenon::PlanarPath& path,
                                const tenon::LeggedState& state, double height, Legs& legs) const {
    const auto& robot = params.robot;
    tenon::Vec<2> center_B(0, 0);  // center of the feet in the nominal stance, which follows the path
    for (int i = 0; i < tenon::kNumLegs; ++i) center_B += robot.FootPosition(i, robot.stance).head<2>() / 4;
    tenon::FeetReference feet;
    for (int i = 0; i < tenon::kNumLegs; ++i) {
      Leg& leg = legs[static_cast<std::size_t>(i)];
      const tenon::LegContact& contact = schedule.legs[static_cast<std::size_t>(i)];
      if (contact.stance() || !leg.swings)
        leg.from = state.p_WB + state.R_WB() * robot.FootPosition(i, state.q);
      leg.swings = !contact.stance();
      feet[i].p_W = leg.from;
      if (contact.stance()) continue;
      const double T = schedule.timing.swing,
                   s = contact.state == tenon::ContactState::kSwing ? contact.phase : 1;
      const tenon::PlanarPath then = path.At((1 - s) * T + schedule.timing.leg_stance() / 2);
      leg.to = then.position_W + then.Heading() * (robot.FootPosition(i, robot.stance).head<2>() - center_B);
      const tenon::Vec<2> way = leg.to - leg.from.head<2>();
      feet[i].p_W.head<2>() += way * s * s * (3 - 2 * s);
      feet[i].v_W.head<2>() = way * 6 * s * (1 - s) / T;
      feet[i].a_W.head<2>() = way * (6 - 12 * s) / (T * T);
      leg.late = s < 1 ? 0 : leg.late + params.rate.period();
      feet[i].p_W[2] += 16 * height * s * s * (1 - s) * (1 - s) - params.lowering * leg.late;
      feet[i].v_W[2] = s < 1 ? 32 * height * s * (1 - s) * (1 - 2 * s) / T : -params.lowering;
      feet[i].a_W[2] = s < 1 ? 32 * height * (1 - 6 * s + 6 * s * s) / (T * T) : 0;
    }
    return feet;
  }
};
