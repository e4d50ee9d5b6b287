#pragma once

#include <array>

namespace tenon {

inline constexpr int kNumLegs = 4;
inline constexpr int kJointsPerLeg = 3;
inline constexpr int kNumJoints = kNumLegs * kJointsPerLeg;  ///< joint 3 leg + i is joint i of the leg

/// Index of a leg.
enum Leg { kFrontLeft, kFrontRight, kRearLeft, kRearRight };
constexpr bool IsFront(int leg) {
  return leg == kFrontLeft || leg == kFrontRight;
}
constexpr bool IsLeft(int leg) {
  return leg == kFrontLeft || leg == kRearLeft;
}
inline constexpr std::array<const char*, kNumLegs> kLegNames{"front_left", "front_right", "rear_left",
                                                             "rear_right"};
/// Names of legs and joints as elements of signals; the names of a robot's joints are in JointDescription.
inline constexpr const char* kLegElements = "front_left,front_right,rear_left,rear_right";
inline constexpr const char* kJointElements =
    "front_left_abduction,front_left_hip_pitch,front_left_knee,"
    "front_right_abduction,front_right_hip_pitch,front_right_knee,"
    "rear_left_abduction,rear_left_hip_pitch,rear_left_knee,"
    "rear_right_abduction,rear_right_hip_pitch,rear_right_knee";

}  // namespace tenon
