#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/robots/robot_links.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/io/recording.h>

#include <filesystem>

namespace tenon::apps {

/// The sensors of a quadruped in an MCAP file. Times are relative to the first sample of the last topic that
/// begins [s].
struct SensorLog {
  Recording<JointMotion> joints;
  Recording<Vec<12>> torque;    ///< measured [N m]
  Recording<Vec<12>> commands;  ///< /joint_commands [N m]; may be empty
  Recording<ImuMeasurement> imu;
  std::array<Recording<Vec<3>>, kNumLegs> feet;  ///< ground forces in the axes of the trunk [N]
  Recording<LeggedState> odometry;               ///< /odom, pose and velocity; may be empty
  Recording<LeggedState> truth;                  ///< /ground_truth, as odometry
  double start = 0;                              ///< stamp of the time 0 [s]
  double end = 0;                                ///< last time at which all topics have samples [s]
  Rate rate = Hz(1000);                          ///< of joints or IMU, whichever is slower
  long gaps = 0;                                 ///< intervals of more than 2.5 periods of a topic
  double longest_gap = 0;                        ///< [s]
  std::vector<std::string> told;                 ///< damage, refused messages and gaps
};

/// Reads JointState and Imu, and WrenchStamped of the feet if there are foot sensors, with the topics and
/// frames of QuadrupedMessages; the frame of the IMU may be any link at rest in the trunk. Times are the
/// stamps, or without stamps the times of recording. Throws ParameterError for a file without whole
/// messages of a topic, and for another robot.
SensorLog ReadSensorLog(const std::filesystem::path& file, const QuadrupedDescription& robot,
                        const RobotLinks& links, bool foot_sensors);

}  // namespace tenon::apps
