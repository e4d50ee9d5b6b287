#pragma once

#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/framework/types/diagonal_gains.h>

namespace tenon {

/// Gains of AdmittanceFilter. The defaults are explained in docs/guide_dog.md.
struct AdmittanceGains {
  double desired_tension = 30;  ///< desired tension f_d of the leash [N]
  DiagonalGains mass = 8;       ///< mass M_a of the admittance, forward and left [kg]
  DiagonalGains damping = 40;   ///< damping D_a of the admittance, forward and left [N s/m]
  double stiffness = 100;       ///< stiffness K_a of the admittance across the path [N/m]
  double min_forward = 0.03;    ///< minimum forward velocity; only the Supervisor stops the robot [m/s]
  double max_forward = 0.2;     ///< maximum forward velocity due to the leash [m/s]
  double max_left = 0.05;       ///< maximum lateral velocity to either side [m/s]
  double acceleration = 0.5;    ///< maximum acceleration of the forward and lateral velocities [m/s^2]
  double adaptation_rate = 0;   ///< rate at which the forward velocity adapts to the person's [1/s]
  double yield_tension = 0;     ///< horizontal pull above which a standing robot yields; 0: never [N]
  double yield_time = 0;        ///< accumulated time of such a pull before the robot yields [s]
  double max_backward = 0.3;    ///< maximum backward velocity of a robot that yields [m/s]

  static FieldList Fields() {
    using G = AdmittanceGains;
    return {Field("desired_tension_N", &G::desired_tension).Positive(),
            Field("mass_kg", &G::mass).Positive(),
            Field("damping_N_s_per_m", &G::damping).Positive(),
            Field("stiffness_N_per_m", &G::stiffness).AtLeast(0),
            Field("min_forward_m_per_s", &G::min_forward).AtLeast(0),
            Field("max_forward_m_per_s", &G::max_forward).Finite(),
            Field("max_left_m_per_s", &G::max_left).AtLeast(0),
            Field("acceleration_m_per_s2", &G::acceleration).Positive(),
            Field("adaptation_rate_per_s", &G::adaptation_rate).AtLeast(0),
            Field("yield_tension_N", &G::yield_tension).AtLeast(0),
            Field("yield_time_s", &G::yield_time).AtLeast(0),
            Field("max_backward_m_per_s", &G::max_backward).AtLeast(0)};
  }
  void Validate() const;  ///< throws ParameterError
};

struct AdmittanceFilterParams {
  AdmittanceGains gains;
  Rate rate = Hz(100);
};

/// State of AdmittanceFilter.
struct AdmittanceMotion {
  double tension = 0;                  ///< T, estimated; negative if the person pulls ahead [N]
  Vec<2> direction = Vec<2>::Zero();   ///< e: forward and left
  Vec<2> velocity = Vec<2>::Zero();    ///< corrected command, forward and left [m/s]
  Vec<2> correction = Vec<2>::Zero();  ///< x~', the correction of the command [m/s]
  double offset = 0;                   ///< x~ across the path, to the left [m]
  bool walks = false;                  ///< the robot walks: the command has a gait, or the robot yields

  static FieldList Fields() {
    using M = AdmittanceMotion;
    return {{"tension", &M::tension, "N"},     {"direction", &M::direction},
            {"velocity", &M::velocity, "m/s"}, {"correction", &M::correction, "m/s"},
            {"offset", &M::offset, "m"},       {"walks", &M::walks}};
  }
};

/// Adapts a walk to the person on the leash by the admittance of Morlando 2023, eq. (2.49), written as a
/// force balance of the tension in the frame of the robot's heading (forward, left):
///
///     M_a x~'' + D_a x~' + K x~ = (f_d - T) e,   K = diag(0, K_a),
///
/// The output is the commanded velocity plus x~'. Without stiffness along the path the robot follows a slow
/// person indefinitely, at the tension f_d + D_a (commanded speed - speed of the person).
///
/// f is the horizontal part of the estimated force on the robot, T = -f.e the tension, and e the direction
/// from the person to the robot,
///
///     e = (f_d h - f) / |f_d h - f|,   h = (1, 0) the heading:
///
/// which points along the leash when it is taut, and ahead when it is slack and f is noise. While the person
/// pulls from ahead, T < 0 or T > f_d along e = -h, so the robot moves towards the pull. The vertical force
/// is not used, since it contains the errors of the robot's mass. Only the yaw of `state` is used.
///
/// The forward velocity is limited to [min_forward, max_forward] and the left velocity to max_left, or to the
/// command if it is beyond; both accelerations are limited by `acceleration`. The limits also apply to x~',
/// which prevents windup. A command to stand passes at once and resets the filter, unless the robot yields.
///
/// **Adaptation.** At a person's pace, a damping D_a that keeps the loop with the leash stable causes the
/// tension to differ from f_d by D_a times the difference of the speeds. With the adaptation_rate r, the
/// forward command gets the correction c with c' = r (f_d - T) e_x / D_a, which is held while a limit acts,
/// and is 0 after a stop.
///
/// **Yielding.** A robot that stops from a person's pace stretches the leash on its way to rest, and a light
/// robot that stands is tipped by a pull to the side. If the horizontal pull exceeds yield_tension > f_d, the
/// robot does not stand: it walks on in its last gait by the equation above with the nominal velocity 0,
/// limited by max_backward and max_left, and not forwards once it has braked, until the pull is below the
/// mean of f_d and yield_tension. Against noise, the time of the pull is accumulated as for the pulls of the
/// Supervisor, also before the stop: up to yield_time before the robot yields, and down to 0 before it
/// stands.
///
/// The force is held between ticks and the equation is integrated exactly.
class AdmittanceFilter final : public LeafSystem<AdmittanceFilterParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  InputPort<LeggedState> state{this, {"state"}};
  Parameter<AdmittanceGains> gains{this, {"gains"}, params.gains, "admittance and limits of the velocities"};

 private:
  /// Transition of (offset, velocity, force) over a tick.
  struct Steps {
    Eigen::Matrix3d along = Eigen::Matrix3d::Zero(), across = Eigen::Matrix3d::Zero();
  };
  Shared<Steps> steps_{this, "steps", Uses(gains), &AdmittanceFilter::CalcSteps};

 public:
  struct Memory {
    AdmittanceMotion motion;
    double adaptation = 0;     ///< c [m/s]
    Gait gait = Gait::kStand;  ///< last gait of the command other than kStand
    bool yields = false;
    double pull_time = 0;  ///< accumulated time of a pull, at most yield_time [s]

    static FieldList Fields() {
      return {{"motion", &Memory::motion},
              {"adaptation", &Memory::adaptation, "m/s"},
              {"gait", &Memory::gait},
              {"yields", &Memory::yields},
              {"pull_time", &Memory::pull_time, "s"}};
    }
  };
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<Memory> progress{this,
                              {"progress"},
                              Sampled{params.rate},
                              Uses(command, wrench, state, gains, steps_, memory),
                              &AdmittanceFilter::CalcProgress};
  OutputPort<AdmittanceMotion> motion{
      this, {"motion"}, Sampled{params.rate}, Uses(progress), [](const Memory& m) { return m.motion; }};
  OutputPort<WalkCommand> walk{
      this, {"walk"}, Sampled{params.rate}, Uses(command, progress), &AdmittanceFilter::CalcWalk};

 private:
  Memory CalcProgress(const WalkCommand& command, const WrenchEstimate& wrench, const LeggedState& state,
                      const AdmittanceGains& gains, const Steps& steps, Memory& memory) const;
  WalkCommand CalcWalk(const WalkCommand& command, const Memory& progress) const;
  Steps CalcSteps(const AdmittanceGains& gains) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::AdmittanceMotion);
