#pragma once

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct LegErrorsParams {
  QuadrupedDescription robot;        ///< true model of the robot
  double min_singular_value = 0.02;  ///< of the Jacobian of a force's point, see SolveForce [m]
  Rate rate = Hz(1000);
};

/// Forces on the legs at the points where they act.
struct ForcesAtPoints {
  FootForces force;               ///< the part of the disturbing force that loads the joints [N]
  FootForces estimate;            ///< its estimate [N]
  Vec<4> error = Vec<4>::Zero();  ///< |estimate - force| [N]

  static FieldList Fields() {
    return {{"force", &ForcesAtPoints::force},
            {"estimate", &ForcesAtPoints::estimate},
            {"error", &ForcesAtPoints::error, "N", kLegElements}};
  }
};

/// Errors of the legs as Morlando 2023 plots them (section 2.5): of the feet in all phases, and of the
/// estimated forces at the points where the disturbances act. They are figures of merit and must not be fed
/// back. `foot` is |p - p_ref| of each foot, and `geometry` shows the planned footholds as spheres: those of
/// `feet` if `footholds` is not connected.
///
/// **Feet.** The reference of a swing foot is that of `feet`. The reference of a stance foot is the foothold
/// that was planned for its last swing, on the ground as the controller estimated it at lift-off: a foot on a
/// block has the height of the block as an error. Before its first step the error of a foot is 0.
///
/// **Forces.** With J the Jacobian of the leg's joints at the point p of the force that acts on it, the force
/// is the least-squares solution of least norm of J^T f = tau, with tau once the torque of the disturbances
/// and once the estimate. A point between hip and knee moves with two joints only, so `force` lacks the
/// component that no joint feels. A leg without a force has p at the foot; with several, p of the first.
class LegErrors final : public LeafSystem<LegErrorsParams> {
 public:
  using LeafSystem::LeafSystem;
  using Points = std::array<Vec<3>, kNumLegs>;
  static Points Origins() {
    Points points;
    points.fill(Vec<3>::Zero());
    return points;
  }

  /// The last planned footholds.
  struct Memory {
    Points foothold = Origins();         ///< [m]
    std::array<bool, kNumLegs> swung{};  ///< whether the leg has stepped

    static FieldList Fields() {
      return {{"foothold", &Memory::foothold, "m", kLegElements},
              {"swung", &Memory::swung, "", kLegElements}};
    }
  };

  InputPort<LeggedState> state{this, {"state"}};
  InputPort<ExternalForces> external{this, {"external"}, ExternalForces{}};
  InputPort<Vec<12>> external_torque{this, {"external_torque", "N m"}, Vec<12>(Vec<12>::Zero())};
  InputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}, LegForceEstimate()};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<FeetReference> feet{this, {"feet"}};
  InputPort<Points> footholds{this, {"footholds", "m", kLegElements}, Origins()};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<Vec<4>> foot{this,
                          {"foot", "m", kLegElements},
                          Sampled{params.rate},
                          Uses(state, schedule, feet, footholds, memory),
                          &LegErrors::CalcFoot};
  OutputPort<ForcesAtPoints> forces{
      this, {"forces"}, Uses(state, external, external_torque, leg_forces), &LegErrors::CalcForces};
  OutputPort<Geometry> geometry{
      this, {"geometry"}, MakeShapes(params.robot), Uses(footholds), &LegErrors::CalcGeometry};

 private:
  static Geometry MakeShapes(const QuadrupedDescription& robot);
  Vec<4> CalcFoot(const LeggedState& state, const ContactSchedule& schedule, const FeetReference& feet,
                  const Points& footholds, Memory& memory) const;
  ForcesAtPoints CalcForces(const LeggedState& state, const ExternalForces& external,
                            const Vec<12>& external_torque, const LegForceEstimate& leg_forces) const;
  void CalcGeometry(const Points& footholds, Geometry* geometry) const {
    for (std::size_t i = 0; i < kNumLegs; ++i) (*geometry)[i].p_W = footholds[i];
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::ForcesAtPoints);
