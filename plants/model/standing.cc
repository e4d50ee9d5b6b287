#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/model/standing.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/analysis/internal/small_matrices.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>

namespace tenon {
namespace {

/// Returns the first joint that is out of its range, or kNumJoints.
int JointBeyondItsRange(const QuadrupedDescription& robot, const Vec<12>& q) {
  int j = 0;
  while (j < kNumJoints && q[j] >= robot.joint(j).lower && q[j] <= robot.joint(j).upper) ++j;
  return j;
}

}  // namespace

LeggedState StandingOn(const QuadrupedDescription& robot, const GroundPlane& ground, double yaw,
                       const Vec<2>& feet_shift) {
  const QuadrupedModel model(robot);
  LeggedState x;
  x.q = robot.stance;
  QuadrupedDynamics dynamics;
  model.Calc(x, &dynamics);

  const Eigen::Vector3d com_B = dynamics.com_W;
  const Eigen::Matrix3d R_WB = RotationFromEuler(EulerOnSlope(ground.slope, yaw));
  const Eigen::Matrix2d footprint = R_WB.topLeftCorner<2, 2>();
  const Eigen::Vector2d middle = ground.p_W.head<2>();
  const auto above = [&](const Eigen::Vector3d& p_B, double height, const Vec<2>& shift) {
    const Eigen::Vector2d place = middle + footprint * p_B.head<2>() + shift;
    return Eigen::Vector3d(place[0], place[1], ground.HeightAt(place) + height);
  };
  const Eigen::Vector3d com_W = above(com_B, robot.StanceHeight() + com_B[2], Vec<2>::Zero());
  x.p_WB = com_W - R_WB * com_B;
  x.q_WB = QuaternionFromRotation(R_WB);
  const double center_height =
      robot.foot_radius /
      ground.Normal()[2];  // height of the centre of a foot's sphere that touches the plane
  std::array<Eigen::Vector3d, kNumLegs> target;
  for (std::size_t i = 0; i < kNumLegs; ++i)
    target[i] = above(dynamics.feet[i].p_W, center_height, feet_shift);

  const auto refuse = [&](std::ptrdiff_t leg) {
    throw ParameterError(fmt::format(
        "the {} leg of '{}' does not reach ground of slope ({}, {}) from its nominal stance within the "
        "ranges of its joints; reduce the slope, or bend the knees of nominal_stance",
        kLegNames[static_cast<std::size_t>(leg)], robot.name, ground.slope[0], ground.slope[1]));
  };
  // Newton's method for each leg; the trunk is moved to keep the CoM at its target.
  constexpr int kMostSteps = 100;
  constexpr double kTolerance = 1e-9;                    // m
  constexpr double kLongestStep = std::numbers::pi / 8;  // largest step of a joint angle [rad]
  std::array<double, kNumLegs> error{};
  for (int step = 0; step < kMostSteps; ++step) {
    model.Calc(x, &dynamics);
    const Eigen::Vector3d off = com_W - dynamics.com_W;
    double worst = off.norm();
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      error[i] = (target[i] - dynamics.feet[i].p_W).norm();
      worst = std::max(worst, error[i]);
    }
    if (worst <= kTolerance) {
      const int beyond = JointBeyondItsRange(robot, x.q);
      if (beyond < kNumJoints) refuse(beyond / kJointsPerLeg);
      return x;
    }
    x.p_WB += off;
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      const Eigen::Vector3d missing = target[i] - dynamics.feet[i].p_W - off;
      const Eigen::Vector3d turn = internal::SolveLu<3>(dynamics.feet[i].J_leg, missing);
      x.q.segment<3>(kJointsPerLeg * static_cast<int>(i)) +=
          turn.cwiseMax(-kLongestStep).cwiseMin(kLongestStep);
    }
  }
  refuse(std::max_element(error.begin(), error.end()) - error.begin());
  return x;
}

}  // namespace tenon
