#pragma once

#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/model/rope.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct RopeTensionsParams {
  QuadrupedDescription robot;  ///< the controller's model
  std::vector<Rope> ropes;
  double share = 1;     ///< s: part of the weight's component along the slope that the ropes carry
  double friction = 1;  ///< mu of the feet
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Commands the tensions of a quadruped's ropes, and outputs the wrench of the measured ones.
///
/// **Nominal tensions.** The ropes are to exert a force w_n that carries the part s of the weight's component
/// along the slope, and no moment about the CoM. With the ground's normal n and the ropes' unit wrenches,
/// force over moment, as columns of A, the nominal tensions t_n are
///
///     min |A t - (w_n, 0)|^2_Q + e |t|^2   subject to   tension_min <= t <= tension_max,
///     w_n = s m g (e_z - (e_z . n) n),     Q = diag(1, 1, 1, 1/h^2, 1/h^2, 1/h^2),
///
/// with the CoM's height h in the nominal stance. With s = 1 and ropes that can exert w_n, the feet carry
/// m g (e_z . n) n, a force along the normal that needs no friction.
///
/// **Command.** One program distributes the wrench w of the reference over ropes and feet. With the forces f
/// of the feet, their wrench G f about the CoM, and the parts f_t along the ground and f_n along its normal,
///
///     min |A t + G f - w|^2_Q + e_1 |t - t_n|^2 + e_2 |f_t - f_t0|^2 + e_3 |f_n - f_n0|^2
///     subject to   tension_min <= t <= tension_max,   f within the pyramid inscribed in the cone of mu,
///     w = (m (x_ref'' + g e_z) - f_hat, -t_hat),   f_t0 = (1 - s) w_t / k,   f_n0 = (w - A t_n)_n / k,
///
/// with e_1 = e_2 / 10 and k feet. t = t_n if the feet need no friction. Ropes carry the larger part of other
/// forces along the slope, such as a load that the observer estimates as (f_hat, t_hat), and all that exceeds
/// the friction of the feet. The k feet are those that stand and those in swing: tensions are distributed for
/// the mean support of a gait, because winches are slower than steps. Late and searching feet do not count.
/// The forces f are not commanded; the whole-body controller computes those that suit the measured tensions.
/// Connect `wrench` to its known_wrench, and to those of swing planner and observer.
///
/// **Hanging.** If no foot counts, the ropes hold the robot like the cables of a cable robot. Then w also has
/// the feedback m (k_p (x_ref - x) + k_d (x_ref' - x')) and I (k_p e + k_d (w_ref - w)), with the rotation e
/// to the reference, k_p = 25 / s^2 and k_d = 10 / s: slower than a winch with a lag of 50 ms.
///
/// **Lost ropes.** A rope whose measured tension stays below 0.3 of its command for 50 ms is lost: from then
/// on, the others are distributed without it.
///
///     | port     | kind            | type                                                             |
///     | state    | input           | LeggedState                                                      |
///     | ground   | input           | GroundPlane                                                      |
///     | schedule | input           | ContactSchedule; all feet stand if not connected                 |
///     | body     | input           | BodyReference; its acceleration is 0 if not connected            |
///     | external | input           | WrenchEstimate of an observer; zero if not connected             |
///     | tension  | input           | measured tensions [N]                                            |
///     | plan     | output, sampled | commands, and the time for which each rope has lacked tension    |
///     | command  | output, sampled | tensions [N]                                                     |
///     | lost     | output, sampled | 1 for a lost rope, else 0                                        |
///     | wrench   | output, sampled | wrench of the measured tensions about the CoM                    |
///     | share    | parameter       | s                                                                |
class RopeTensions final : public LeafSystem<RopeTensionsParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<GroundPlane> ground{this, {"ground"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}, ContactSchedule()};
  InputPort<BodyReference> body{this, {"body"}, BodyReference()};
  InputPort<WrenchEstimate> external{this, {"external"}, WrenchEstimate()};
  InputPort<CableVector> tension{this, {"tension", "N", RopeElements(params.ropes)}};
  Parameter<double> share{this,
                          {"share"},
                          params.share,
                          "part of the weight's component along the slope that the ropes carry",
                          Range().Between(0, 2)};

  struct Plan {
    Vec<kMaxRopes> command = Vec<kMaxRopes>::Zero();  ///< [N]
    Vec<kMaxRopes> missing = Vec<kMaxRopes>::Zero();  ///< time with too little tension [s]

    static FieldList Fields() { return {{"command", &Plan::command, "N"}, {"missing", &Plan::missing, "s"}}; }
  };

 private:
  using UnitWrenches = Eigen::Matrix<double, 6, kMaxRopes, Eigen::DontAlign>;  // one column for each rope
  struct Limbs {
    UnitWrenches ropes;
    std::array<Vec<3>, kNumLegs> feet;  // centres of the feet from the CoM [m]
    Vec<3> com_W, com_velocity_W, w_W;
    Vec<4> q_WB;
    Eigen::Matrix3d inertia_W;  // about the CoM [kg m^2]
  };
  struct Bounds {
    Vec<kMaxRopes> lower, upper;  // of the tensions [N]
  };
  struct Support {
    std::array<bool, kNumLegs> feet{};  // the feet that count
    int count = 0;
    Vec<3> normal, t_1, t_2, contact;  // axes of the ground, vector from a foot's centre to its contact
  };
  struct Solvers {
    DualActiveSet nominal{kMaxRopes, 2 * kMaxRopes};
    DualActiveSet joint{kMaxRopes + 3 * kNumLegs, 2 * kMaxRopes + 4 * kNumLegs};
  };
  const QuadrupedModel model_{params.robot};
  Shared<Limbs> limbs_{this, "limbs", Uses(state), &RopeTensions::CalcLimbs};
  Scratch<Plan> memory_{this, "memory", Plan()};
  Workspace<Solvers> solvers_{this, "solvers"};

 public:
  OutputPort<Plan> plan{this,
                        {"plan"},
                        Sampled{params.rate},
                        Uses(limbs_, ground, schedule, body, external, tension, share, memory_, solvers_),
                        &RopeTensions::CalcPlan};
  OutputPort<CableVector> command{this,
                                  {"command", "N", RopeElements(params.ropes)},
                                  CableVector::Zero(static_cast<Eigen::Index>(params.ropes.size())),
                                  Sampled{params.rate},
                                  Uses(plan),
                                  &RopeTensions::CalcCommand};
  OutputPort<CableVector> lost{this,
                               {"lost", "", RopeElements(params.ropes)},
                               CableVector::Zero(static_cast<Eigen::Index>(params.ropes.size())),
                               Sampled{params.rate},
                               Uses(plan),
                               &RopeTensions::CalcLost};
  OutputPort<WrenchEstimate> wrench{
      this, {"wrench"}, Sampled{params.rate}, Uses(limbs_, tension), &RopeTensions::CalcWrench};

  /// The command in one state of the robot, at rest there, without other forces [N].
  CableVector CommandAt(const LeggedState& state, const GroundPlane& ground,
                        const ContactSchedule& schedule) const;

 private:
  void CalcLimbs(const LeggedState& state, Limbs* limbs) const;
  void CalcPlan(const Limbs& limbs, const GroundPlane& ground, const ContactSchedule& schedule,
                const BodyReference& body, const WrenchEstimate& external, const CableVector& tension,
                double share, Plan& memory, Solvers& solvers, Plan* plan) const;
  void CalcCommand(const Plan& plan, CableVector* command) const;
  void CalcLost(const Plan& plan, CableVector* lost) const;
  WrenchEstimate CalcWrench(const Limbs& limbs, const CableVector& tension) const;
  void Watch(const CableVector& tension, Plan* memory) const;
  Bounds BoundsOf(const Plan& memory) const;
  Support SupportOf(const GroundPlane& ground, const ContactSchedule& schedule) const;
  Vec<6> WrenchOf(const Limbs& limbs, const BodyReference& body, const WrenchEstimate& external,
                  bool hangs) const;
  Vec<kMaxRopes> Nominal(const UnitWrenches& ropes, const Vec<3>& normal, const Bounds& bounds, double share,
                         DualActiveSet& solver) const;
  Vec<kMaxRopes> Distribute(const Limbs& limbs, const Support& support, const Vec<6>& wrench,
                            const Vec<kMaxRopes>& nominal, const Bounds& bounds, double share,
                            DualActiveSet& solver) const;
};

}  // namespace tenon
