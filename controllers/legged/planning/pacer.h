#pragma once

#include <tenon/controllers/legged/planning/foot_scheduler.h>
#include <tenon/plants/model/quadruped_description.h>

namespace tenon {

/// Limits of a Pacer. Units l, g and t are those of RobotScale.
struct PaceProperties {
  double acceleration = 0.08;   ///< largest acceleration of the command [g]
  double yaw_acceleration = 1;  ///< largest yaw acceleration of the command [rad/s^2]
  double stride = 2.3;          ///< stride over hip height at the Froude number 1, see Pacer
  double swing_speed = 0.7;     ///< mean speed of a swing foot up to which the swing is as in the table [l/t]
  double least_stance = 0.13;   ///< shortest stance of all feet between two swings [t]
  double drive_speed = 0.8;     ///< usable part of the drives' speed limit
  double reach = 0.8;           ///< usable part of the legs' reach in a stance

  static FieldList Fields() {
    return {Field("acceleration_g", &PaceProperties::acceleration).Positive(),
            Field("yaw_acceleration_rad_per_s2", &PaceProperties::yaw_acceleration).Positive(),
            Field("stride", &PaceProperties::stride).Positive(),
            Field("swing_speed_l_per_t", &PaceProperties::swing_speed).Positive(),
            Field("least_stance_t", &PaceProperties::least_stance).AtLeast(0),
            Field("drive_speed", &PaceProperties::drive_speed).Positive(),
            Field("reach", &PaceProperties::reach).Positive()};
  }
};

struct PacerParams {
  QuadrupedDescription robot;
  GaitTable gaits;  ///< timing at low speed
  PaceProperties pace{};
  double gravity = kGravity;  ///< [m/s^2]
  Rate rate = Hz(1000);

  void Validate() const;  ///< throws ParameterError
};

/// Adapts a commanded walk to what the feet can follow, and the timing of the gait to the speed.
///
/// **Timing.** With the hip height h, the speed v of the fastest foot's hip, and the Froude number Fr = v^2 /
/// (g h), animals of all sizes have the stride v T = c h Fr^0.3, c = 2.3 (Alexander 1984, The gaits of
/// bipedal and quadrupedal animals). The cycle T is the shorter of this one and that of the table. In each
/// of its n steps, the swing lasts
///
///     T_sw = max(T_table, v T / (k sqrt(g l)), 15/8 v T / (r w h + v)),   T_sw <= T / n - T_min.
///
/// The second term limits the mean speed of a swing foot. The third one limits the angular speed of the leg
/// in the middle of a swing, where a foot that moves along a polynomial of degree five is 15/8 times faster
/// than on average, to the part r of the speed limit w of the hip pitch drives. The remaining T / n - T_sw
/// is the stance of all feet. At low speed the timing is that of the table.
///
/// **Top speed.** In the stance a hip moves over its foot by v (T - T_sw), at most a given part of the leg's
/// reach to both sides. This and the limit of the drives yield the top speed of each gait.
///
/// **Ramp.** Velocities follow the command with limited acceleration, forward and left along a straight line,
/// up to the top speed of the commanded gait, where a turn counts with the distance of the feet. A gait
/// follows the commanded one once the speed is below the top speed of the new gait: the robot slows down
/// before it crawls, and stands only after it has come to rest.
class Pacer final : public LeafSystem<PacerParams> {
 public:
  explicit Pacer(const PacerParams& params);

  /// The velocities and gait of `paced` at the last tick.
  struct Progress {
    Gait gait = Gait::kStand;
    Vec<3> velocity = Vec<3>::Zero();  ///< forward, left [m/s], yaw rate [rad/s]

    static FieldList Fields() { return {{"gait", &Progress::gait}, {"velocity", &Progress::velocity}}; }
  };

  /// Timing of a gait at a speed of the feet [m/s]; no steps for Gait::kStand.
  GaitTiming TimingAt(Gait gait, double speed) const;
  /// Top speed of a gait [m/s]; 0 for Gait::kStand.
  double TopSpeed(Gait gait) const { return top_speed_[static_cast<std::size_t>(gait)]; }

  InputPort<WalkCommand> command{this, {"command"}};
  Scratch<Progress> progress{this, "progress"};
  OutputPort<WalkCommand> paced{
      this, {"paced"}, Sampled{params.rate}, Uses(command, progress), &Pacer::CalcPaced};
  OutputPort<GaitTiming> timing{this, {"timing"}, Sampled{params.rate}, Uses(paced), &Pacer::CalcTiming};

 private:
  WalkCommand CalcPaced(const WalkCommand& command, Progress& progress) const;
  GaitTiming CalcTiming(const WalkCommand& paced) const {
    return TimingAt(paced.gait, SpeedOfFeet({paced.forward, paced.left, paced.yaw_rate}));
  }
  double SpeedOfFeet(const Vec<3>& velocity) const {
    return velocity.head<2>().norm() + std::abs(velocity[2]) * foot_radius_;
  }
  bool Feasible(Gait gait, double speed) const;

  double hip_height_, length_, foot_radius_, reach_, drive_speed_;
  std::array<GaitTiming, 5> table_;
  std::array<double, 5> top_speed_{};
};

}  // namespace tenon
