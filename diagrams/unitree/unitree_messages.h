#pragma once

#include <tenon/plants/signals/imu_signals.h>
#include <tenon/plants/signals/joint_command.h>
#include <tenon/systems/dds/dds.h>

namespace tenon {

/// @file
/// Signals of the low-level interface of Unitree's Go2 and B2, in Tenon's order of legs and joints. The
/// messages are those of unitree_go.idl; their mapping is in unitree_messages.cc alone.

/// Command of a client, topic "rt/lowcmd". A motor that is off, and a gain whose target is absent, have
/// zeros.
struct UnitreeCommand : JointCommand {};

/// State of a robot, topic "rt/lowstate".
struct UnitreeState {
  double time = 0;  ///< time of the robot, in whole milliseconds; begins anew after 49 days [s]
  JointMotion joints;
  Vec<12> torque = Vec<12>::Zero();  ///< estimate of the motors [N m]
  ImuMeasurement inertial;
  Vec<4> q_WB{1, 0, 0, 0};             ///< attitude of the inertial unit, (w, x, y, z)
  Vec<4> foot_force = Vec<4>::Zero();  ///< magnitudes, in whole units of the robot's sensors [N]
  int buttons = 0;                     ///< bits of the remote's pressed buttons

  static constexpr int kL2 = 5, kB = 9;  ///< bits of two buttons

  static FieldList Fields() {
    return {{"time", &UnitreeState::time, "s"},
            {"joints", &UnitreeState::joints},
            {"torque", &UnitreeState::torque, "N m", kJointElements},
            {"inertial", &UnitreeState::inertial},
            {"q_WB", &UnitreeState::q_WB, "", "w,x,y,z"},
            {"foot_force", &UnitreeState::foot_force, "N", kLegElements},
            {"buttons", &UnitreeState::buttons}};
  }
};

template <>
struct DdsMessageOf<UnitreeCommand> {
  static const DdsMessage& Get();
};
template <>
struct DdsMessageOf<UnitreeState> {
  static const DdsMessage& Get();
};

/// The checksums of the messages that these values are sent as.
std::uint32_t ChecksumOf(const UnitreeCommand& command);
std::uint32_t ChecksumOf(const UnitreeState& state);

/// The checksum of the messages: CRC-32 with the polynomial 04C11DB7 and the initial value FFFFFFFF, most
/// significant bit first, neither reflected nor inverted.
std::uint32_t UnitreeCrc(std::span<const std::uint32_t> words);

}  // namespace tenon
