#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct JointPdParams {
  QuadrupedDescription robot = {};   ///< model of the controller
  double stiffness = 0;              ///< K_p [N m/rad]
  double damping = 0;                ///< K_d [N m s/rad]
  bool gravity_compensation = true;  ///< add StandingTorque
  double gravity = kGravity;         ///< [m/s^2]
  Rate rate = Hz(1000);

  void Validate() const;  ///< throws ParameterError unless K_p > 0 and K_d >= 0
};

/// Gains for a robot of any size and weight, K_p = 3.886 m g l per rad and K_d = 0.3099 m g l t, see
/// RobotScale. They are scaled from DogBot's 500 N m/rad and 10 N m s/rad. A push of a tenth of the robot's
/// weight moves the trunk by a hundredth of the leg's length.
JointPdParams MakeJointPd(const QuadrupedDescription& robot);

/// The joint torques at which a robot stands still in its nominal stance, level, on four feet [N m]:
///
///     tau = g_q - sum_i J_i^T f_i,   f_i = (0, 0, N_i),
///
/// with g_q the joints' rows of the gravity term and N the vertical forces of least norm that carry the
/// weight without a moment about the centre of mass. Throws ParameterError if the feet lie in a line.
Vec<12> StandingTorque(const QuadrupedDescription& robot, double gravity);

/// Holds joint angles:
///
///     tau = K_p (q_ref - q) - K_d qd + StandingTorque,   kept within the torque limits of the joints.
///
/// Without `reference`, q_ref is the nominal stance.
class JointPd final : public LeafSystem<JointPdParams> {
 public:
  explicit JointPd(const JointPdParams& params);

  InputPort<JointMotion> joints{this, {"joints"}};
  InputPort<Vec<12>> reference{this, {"reference", "rad"}, params.robot.stance};
  Parameter<double> stiffness{this,
                              {"stiffness", "N m/rad"},
                              params.stiffness,
                              "gain K_p of the joint angles",
                              Range().Positive().Because("with 0 errors are not corrected")};
  Parameter<double> damping{this,
                            {"damping", "N m s/rad"},
                            params.damping,
                            "gain K_d of the joint speeds",
                            Range().AtLeast(0).Because("negative damping is unstable")};
  OutputPort<Vec<12>> torque{this,
                             {"torque", "N m", kJointElements},
                             Sampled{params.rate},
                             Uses(joints, reference, stiffness, damping),
                             &JointPd::CalcTorque};

 private:
  Vec<12> CalcTorque(const JointMotion& joints, const Vec<12>& reference, double stiffness,
                     double damping) const;

  Vec<12> feedforward_ = Vec<12>::Zero();
  Vec<12> limit_;
};

}  // namespace tenon
