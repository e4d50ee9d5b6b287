#pragma once

#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/model/rope.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

struct RopeTensionsParams {
  QuadrupedDescription robot;  ///< the controller's model
  std::vector<Rope> ropes;
  double share = 1;  ///< s: part of the weight's component along the slope that the ropes carry
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Commands the tensions of a quadruped's ropes, and outputs the wrench of the measured ones.
///
/// The ropes are to exert a force w that carries the part s of the weight's component along the slope, and no
/// moment about the CoM. With the ground's normal n and the ropes' unit wrenches, force over moment, as
/// columns of A, the tensions t are
///
///     min |A t - (w, 0)|^2_Q + e |t|^2   subject to   tension_min <= t <= tension_max,
///     w = s m g (e_z - (e_z . n) n),     Q = diag(1, 1, 1, 1/h^2, 1/h^2, 1/h^2),
///
/// with the CoM's height h in the nominal stance. With s = 1 and ropes that can exert w, the feet carry
/// m g (e_z . n) n, a force along the normal that needs no friction. The rest of the wrench is left to the
/// feet: connect `wrench` to the known_wrench of the whole-body controller, the swing planner and the
/// observer.
///
///     | port    | kind            | type                                          |
///     | state   | input           | LeggedState                                   |
///     | ground  | input           | GroundPlane                                   |
///     | tension | input           | measured tensions [N]                         |
///     | command | output, sampled | tensions [N]                                  |
///     | wrench  | output, sampled | wrench of the measured tensions about the CoM |
///     | share   | parameter       | s                                             |
class RopeTensions final : public LeafSystem<RopeTensionsParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<GroundPlane> ground{this, {"ground"}};
  InputPort<CableVector> tension{this, {"tension", "N", RopeElements(params.ropes)}};
  Parameter<double> share{this,
                          {"share"},
                          params.share,
                          "part of the weight's component along the slope that the ropes carry",
                          Range().Between(0, 2)};

 private:
  using UnitWrenches = Eigen::Matrix<double, 6, kMaxRopes, Eigen::DontAlign>;  // one column for each rope
  const QuadrupedModel model_{params.robot};
  Shared<UnitWrenches> unit_wrenches_{this, "unit_wrenches", Uses(state), &RopeTensions::CalcUnitWrenches};
  Workspace<DualActiveSet> solver_{this, "solver", DualActiveSet(kMaxRopes, 2 * kMaxRopes)};

 public:
  OutputPort<CableVector> command{this,
                                  {"command", "N", RopeElements(params.ropes)},
                                  CableVector::Zero(static_cast<Eigen::Index>(params.ropes.size())),
                                  Sampled{params.rate},
                                  Uses(unit_wrenches_, ground, share, solver_),
                                  &RopeTensions::CalcCommand};
  OutputPort<WrenchEstimate> wrench{
      this, {"wrench"}, Sampled{params.rate}, Uses(unit_wrenches_, tension), &RopeTensions::CalcWrench};

  /// The command in one state of the robot [N].
  CableVector CommandAt(const LeggedState& state, const GroundPlane& ground) const;

 private:
  void CalcUnitWrenches(const LeggedState& state, UnitWrenches* out) const;
  void CalcCommand(const UnitWrenches& unit, const GroundPlane& ground, double share, DualActiveSet& solver,
                   CableVector* command) const;
  WrenchEstimate CalcWrench(const UnitWrenches& unit, const CableVector& tension) const;
};

}  // namespace tenon
