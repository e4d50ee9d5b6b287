#pragma once

#include <tenon/plants/signals/gait_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Part of a walk with one gait and constant velocities: a straight line, an arc or a turn in place.
struct WalkSegment {
  Gait gait = Gait::kStand;             ///< gait of the segment, or `stand`
  double forward = 0;                   ///< velocity along the robot's x axis [m/s]
  double left = 0;                      ///< velocity along the robot's y axis [m/s]
  double yaw_rate = 0;                  ///< yaw rate, positive to the left [rad/s]
  std::optional<double> duration = {};  ///< duration of the segment, alternative to `length` [s]
  std::optional<double> length = {};    ///< length of the segment's path, alternative to `duration` [m]
  double squat_amplitude = 0;           ///< amplitude of the oscillation of the CoM's height [m]
  double squat_frequency = 0.5;         ///< frequency of the oscillation of the CoM's height [Hz]

  static FieldList Fields() {
    return {Required("gait", &WalkSegment::gait),
            {"forward_m_per_s", &WalkSegment::forward},
            {"left_m_per_s", &WalkSegment::left},
            {"yaw_rate_rad_per_s", &WalkSegment::yaw_rate},
            Field("duration_s", &WalkSegment::duration).Positive().OrInfinite(),
            Field("length_m", &WalkSegment::length).Positive().OrInfinite(),
            {"squat_amplitude_m", &WalkSegment::squat_amplitude},
            Field("squat_frequency_hz", &WalkSegment::squat_frequency).Positive()};
  }
};

struct WalkScheduleParams {
  std::vector<WalkSegment> segments;  ///< segments of the walk in chronological order
  double acceleration = 0.5;          ///< acceleration from the velocity of one segment to the next [m/s^2]
  double yaw_acceleration = 1;        ///< acceleration from the yaw rate of one segment to the next [rad/s^2]
  Rate rate = Hz(100);

  static FieldList Fields() {
    return {
        Required("segments", &WalkScheduleParams::segments),
        Field("acceleration_m_per_s2", &WalkScheduleParams::acceleration).Positive().OrInfinite(),
        Field("yaw_acceleration_rad_per_s2", &WalkScheduleParams::yaw_acceleration).Positive().OrInfinite(),
        Undescribed(&WalkScheduleParams::rate)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Commands a predefined walk, starting at t = 0.
///
/// A segment starts with the velocities at the end of the previous one and reaches its own by a ramp that is
/// linear in time, as short as both accelerations allow; duration and length of a segment include its ramp. A
/// segment that stands stops at once. The gait changes at once. After the last segment the robot stands.
///
/// The squats are sines of the time since the start of the segment; their amplitude rises and falls as a
/// quintic within the first and the last period, so that height, velocity and acceleration are continuous.
///
/// Throws ParameterError for a segment with neither or both of duration and length, with a length but no
/// speed, and one that is too short for its ramp or for two squats.
class WalkSchedule final : public LeafSystem<WalkScheduleParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Total length and turn of the walk.
  struct Extent {
    double length = 0;  ///< length of the path [m]
    double turn = 0;    ///< sum of the absolute turns [rad]
  };
  Extent extent() const;
  /// End of the last segment [s].
  double end_time() const { return pieces_.back().end; }
  /// End of the last segment's ramp [s].
  double last_ramp_end() const { return pieces_.back().begin + pieces_.back().ramp; }
  OutputPort<WalkCommand> command{
      this, {"command"}, Sampled{params.rate}, Uses(time), &WalkSchedule::CalcCommand};

 private:
  struct Piece {
    double begin, ramp, end;  // begin and end are times, ramp is a duration
    WalkCommand from, to;
    double amplitude, frequency;  // of the squats [m], [rad/s]
  };
  static std::vector<Piece> MakePieces(const WalkScheduleParams& params);
  WalkCommand CalcCommand(const double& time) const;

  const std::vector<Piece> pieces_ = MakePieces(params);
};

}  // namespace tenon
