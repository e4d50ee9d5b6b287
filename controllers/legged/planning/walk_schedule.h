#pragma once

#include <tenon/plants/signals/gait_signals.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/system.h>

#include <optional>
#include <vector>

namespace tenon {

/// A part of a walk with one gait and constant velocities: a straight line, an arc, a turn on the spot.
struct WalkSegment {
  Gait gait = Gait::kStand;             ///< how it walks, if it does
  double forward = 0;                   ///< speed along its own x axis [m/s]
  double left = 0;                      ///< speed along its own y axis [m/s]
  double yaw_rate = 0;                  ///< turning to the left [rad/s]
  std::optional<double> duration = {};  ///< how long it lasts, unless its length says it [s]
  std::optional<double> length = {};    ///< of path, instead of the duration [m]
  double squat_amplitude = 0;           ///< of the CoM's height about the nominal one [m]
  double squat_frequency = 0.5;         ///< of that [Hz]

  static FieldList Fields() {
    return {Required("gait", &WalkSegment::gait),
            {"forward_m_per_s", &WalkSegment::forward},
            {"left_m_per_s", &WalkSegment::left},
            {"yaw_rate_rad_per_s", &WalkSegment::yaw_rate},
            {"duration_s", &WalkSegment::duration},
            {"length_m", &WalkSegment::length},
            {"squat_amplitude_m", &WalkSegment::squat_amplitude},
            {"squat_frequency_hz", &WalkSegment::squat_frequency}};
  }
};

struct WalkScheduleParams {
  std::vector<WalkSegment> segments;  ///< one after the other
  double acceleration = 0.5;          ///< between segments, a choice [m/s^2]
  double yaw_acceleration = 1;        ///< the same of turning [rad/s^2]
  Rate rate = Hz(100);

  static FieldList Fields() {
    return {Required("segments", &WalkScheduleParams::segments),
            {"acceleration_m_per_s2", &WalkScheduleParams::acceleration},
            {"yaw_acceleration_rad_per_s2", &WalkScheduleParams::yaw_acceleration},
            Undescribed(&WalkScheduleParams::rate)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Commands a walk that is known beforehand, from t = 0 on.
///
///     ports out  command   sampled
///
/// A segment begins with the velocities at the end of the one before and goes over to its own on a ramp that
/// is linear in time, as short as both accelerations allow; its duration and length include the ramp; one
/// that stands has none at once. The gait changes at once. After the last segment the robot stands.
///
/// Squats are sines of the time since the segment's beginning; within their first and last period they grow
/// and fade as a quintic, so that height, speed and acceleration do not jump.
///
/// Throws ParameterError for a segment with neither or both of duration and length, with a length but no
/// speed, and one that is too short for its ramp or for two squats.
class WalkSchedule final : public LeafSystem<WalkScheduleParams> {
 public:
  using LeafSystem::LeafSystem;

  /// How far the walk leads.
  struct Extent {
    double length = 0;  ///< of the path [m]
    double turn = 0;    ///< sum of all turns, to either side [rad]
  };
  Extent extent() const;
  /// When the last segment ends [s].
  double end_time() const;
  /// When the last segment has its own velocities [s].
  double last_ramp_end() const;
  OutputPort<WalkCommand> command{
      this, {"command"}, Sampled{params.rate}, Uses(time), &WalkSchedule::CalcCommand};

 private:
  struct Piece {
    double begin, ramp, end;  // times; the ramp's is its duration
    WalkCommand from, to;
    double amplitude, frequency;  // of the squats [m], [rad/s]
  };
  static std::vector<Piece> MakePieces(const WalkScheduleParams& params);
  WalkCommand CalcCommand(const double& time) const;

  const std::vector<Piece> pieces_ = MakePieces(params);
};

}  // namespace tenon
