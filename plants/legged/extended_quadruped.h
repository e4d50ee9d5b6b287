#pragma once

#include <tenon/plants/legged/quadruped_body.h>
#include <tenon/plants/multibody/extended_robot.h>
#include <tenon/plants/signals/disturbance_signals.h>

namespace tenon {

class QuadrupedMultibody;

/// Adds to a quadruped's multibody system, see quadruped_multibody.h.
using ExtendQuadruped = std::function<void(QuadrupedMultibody&)>;

/// Accelerations of an extended quadruped, and rates of the added states.
struct ExtendedRates : AddedRates {
  LeggedAcceleration robot;
};

/// An ExtendedRobot with the signals of a quadruped.
class ExtendedQuadruped : public ExtendedRobot {
 public:
  ExtendedQuadruped() = default;
  /// No robot if `extend` is empty. Throws ParameterError as ExtendedRobot does.
  ExtendedQuadruped(const QuadrupedDescription& robot, double gravity, const ExtendQuadruped& extend,
                    const LeggedState& initial);

  static Motion MotionOf(const LeggedState& x);
  void CalcRates(const Vec<12>& torque, std::span<const PointForce> forces, const Eigen::VectorXd& added,
                 ExtendedRates* rates) const;
  WrenchEstimate MomentumRate(const LeggedAcceleration& acceleration, const Vec<3>& p_W) const;
};

}  // namespace tenon
