#include <tenon/diagrams/unitree/unitree_messages.h>
#include <tenon/plants/signals/euler.h>

#include <fmt/core.h>
#include <unitree_go.h>

#include <bit>

namespace tenon {
namespace {

using LowCmd = unitree_go_msg_dds__LowCmd_;
using LowState = unitree_go_msg_dds__LowState_;
// The checksum covers all bytes before it, which therefore are those of the robots.
static_assert(sizeof(LowCmd) == 812 && offsetof(LowCmd, crc) == 808);
static_assert(sizeof(LowState) == 1180 && offsetof(LowState, crc) == 1176);
static_assert(std::endian::native == std::endian::little);

// Targets that are absent. An infinite one is invalid.
constexpr float kNoPosition = 2.146e9f, kNoSpeed = 16000;
bool IsAbsent(float target, float mark) {
  return std::isfinite(target) && target >= mark;
}

/// The robots begin with the legs on the right.
constexpr std::size_t OfRobot(int leg) {
  return static_cast<std::size_t>(leg ^ 1);
}
constexpr std::size_t MotorOf(int joint) {
  return kJointsPerLeg * OfRobot(joint / kJointsPerLeg) + static_cast<std::size_t>(joint % kJointsPerLeg);
}

template <class Message>
std::uint32_t CrcOf(const Message& message) {
  std::array<std::uint32_t, sizeof(Message) / 4 - 1> words;
  std::memcpy(words.data(), &message, sizeof words);
  return UnitreeCrc(words);
}

/// Begins a message as the robots do.
void SetHead(auto& message) {
  message.head[0] = 0xFE;
  message.head[1] = 0xEF;
  message.level_flag = 0xFF;
}

/// Returns an empty text, or why the message is damaged.
template <class Message>
std::string CheckCrc(const Message& message) {
  const std::uint32_t crc = CrcOf(message);
  if (crc == message.crc) return "";
  return fmt::format("wrong checksum {:08X}, the content has {:08X}", message.crc, crc);
}

void WriteCommand(const UnitreeCommand& command, LowCmd& message) {
  SetHead(message);
  for (int j = 0; j < kNumJoints; ++j) {
    auto& motor = message.motor_cmd[MotorOf(j)];
    motor.mode = 1;
    motor.q = static_cast<float>(command.q[j]);
    motor.dq = static_cast<float>(command.qd[j]);
    motor.tau = static_cast<float>(command.torque[j]);
    motor.kp = static_cast<float>(command.kp[j]);
    motor.kd = static_cast<float>(command.kd[j]);
  }
  message.crc = CrcOf(message);
}

std::string ReadCommand(const LowCmd& message, UnitreeCommand& command) {
  if (std::string reason = CheckCrc(message); !reason.empty()) return reason;
  command = {};
  for (int j = 0; j < kNumJoints; ++j) {
    const auto& motor = message.motor_cmd[MotorOf(j)];
    if (motor.mode == 0) continue;
    if (motor.kp < 0 || motor.kd < 0)
      return fmt::format("motor {} has a negative gain: kp = {}, kd = {}", MotorOf(j), motor.kp, motor.kd);
    command.torque[j] = motor.tau;
    if (!IsAbsent(motor.q, kNoPosition)) {
      command.q[j] = motor.q;
      command.kp[j] = motor.kp;
    }
    if (!IsAbsent(motor.dq, kNoSpeed)) {
      command.qd[j] = motor.dq;
      command.kd[j] = motor.kd;
    }
  }
  return "";
}

void WriteState(const UnitreeState& state, LowState& message) {
  SetHead(message);
  for (int j = 0; j < kNumJoints; ++j) {
    auto& motor = message.motor_state[MotorOf(j)];
    motor.mode = 1;
    motor.q = static_cast<float>(state.joints.q[j]);
    motor.dq = static_cast<float>(state.joints.qd[j]);
    motor.tau_est = static_cast<float>(state.torque[j]);
  }
  auto& imu = message.imu_state;
  for (int i = 0; i < 4; ++i) imu.quaternion[i] = static_cast<float>(state.q_WB[i]);
  const Eigen::Vector3d euler = EulerFromRotation(RotationFromQuaternion(state.q_WB));
  for (int i = 0; i < 3; ++i) {
    imu.gyroscope[i] = static_cast<float>(state.inertial.angular_velocity_B[i]);
    imu.accelerometer[i] = static_cast<float>(state.inertial.specific_force_B[i]);
    imu.rpy[i] = static_cast<float>(euler[i]);
  }
  constexpr double kMost = std::numeric_limits<std::int16_t>::max();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const double force = std::round(std::clamp(state.foot_force[leg], -kMost, kMost));
    message.foot_force[OfRobot(leg)] = static_cast<std::int16_t>(force);
  }
  message.wireless_remote[2] = static_cast<std::uint8_t>(state.buttons & 0xFF);
  message.wireless_remote[3] = static_cast<std::uint8_t>(state.buttons >> 8 & 0xFF);
  message.tick = static_cast<std::uint32_t>(static_cast<std::uint64_t>(std::llround(1e3 * state.time)));
  message.crc = CrcOf(message);
}

std::string ReadState(const LowState& message, UnitreeState& state) {
  if (std::string reason = CheckCrc(message); !reason.empty()) return reason;
  for (int j = 0; j < kNumJoints; ++j) {
    const auto& motor = message.motor_state[MotorOf(j)];
    state.joints.q[j] = motor.q;
    state.joints.qd[j] = motor.dq;
    state.torque[j] = motor.tau_est;
  }
  for (int i = 0; i < 4; ++i) state.q_WB[i] = message.imu_state.quaternion[i];
  for (int i = 0; i < 3; ++i) {
    state.inertial.angular_velocity_B[i] = message.imu_state.gyroscope[i];
    state.inertial.specific_force_B[i] = message.imu_state.accelerometer[i];
  }
  for (int leg = 0; leg < kNumLegs; ++leg) state.foot_force[leg] = message.foot_force[OfRobot(leg)];
  state.buttons = message.wireless_remote[2] | message.wireless_remote[3] << 8;
  state.time = 1e-3 * message.tick;
  return "";
}

/// Remainders of the bytes.
constexpr auto kCrcTable = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    std::uint32_t& crc = table[byte];
    crc = byte << 24;
    for (int bit = 0; bit < 8; ++bit) crc = crc << 1 ^ (crc >> 31 != 0 ? 0x04C11DB7 : 0);
  }
  return table;
}();

}  // namespace

std::uint32_t UnitreeCrc(std::span<const std::uint32_t> words) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const std::uint32_t word : words) {
    crc ^= word;
    for (int byte = 0; byte < 4; ++byte) crc = crc << 8 ^ kCrcTable[crc >> 24];
  }
  return crc;
}

std::uint32_t ChecksumOf(const UnitreeCommand& command) {
  LowCmd message;
  std::memset(&message, 0, sizeof message);
  WriteCommand(command, message);
  return message.crc;
}
std::uint32_t ChecksumOf(const UnitreeState& state) {
  LowState message;
  std::memset(&message, 0, sizeof message);
  WriteState(state, message);
  return message.crc;
}

const DdsMessage& DdsMessageOf<UnitreeCommand>::Get() {
  static const auto kMessage =
      MakeDdsMessage<LowCmd, UnitreeCommand, WriteCommand, ReadCommand>(&unitree_go_msg_dds__LowCmd__desc);
  return kMessage;
}

const DdsMessage& DdsMessageOf<UnitreeState>::Get() {
  static const auto kMessage =
      MakeDdsMessage<LowState, UnitreeState, WriteState, ReadState>(&unitree_go_msg_dds__LowState__desc);
  return kMessage;
}

}  // namespace tenon
