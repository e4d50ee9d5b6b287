#pragma once

#include <tenon/controllers/legged/observers/contact_aided_filter.h>
#include <tenon/plants/model/gravity.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>

namespace tenon {

/// How far the robot may be from where it is said to start, and the sensors from what they should read:
/// standard deviations per axis.
struct LeggedStartDeviation {
  double position = 1e-3;               ///< [m]
  double velocity = 1e-3;               ///< [m/s]
  double attitude = 2e-3;               ///< [rad]
  double specific_force_bias = 0.02;    ///< [m/s^2]
  double angular_velocity_bias = 2e-3;  ///< [rad/s]
};

struct LeggedStateEstimatorParams {
  QuadrupedDescription robot;
  LeggedState initial;         ///< where it starts
  LeggedStartDeviation start;  ///< how well this is known
  ContactAidedNoise noise;
  double settle_time = 0.02;  ///< a foot counts once it has been in stance so long [s]
  double outlier = 25;  ///< squared Mahalanobis distance (3 degrees of freedom) above which a foot has moved
  double gravity = kGravity;  ///< [m/s^2]
  Rate rate = Hz(1000);       ///< of the filter; that of IMU and encoders should not be lower

  /// Throws ParameterError unless deviations, noise and `outlier` are finite and positive, `settle_time` is
  /// not negative, and the rest is finite, quaternions with a direction.
  void Validate() const;
};

/// What the estimator knows of itself. Deviations are standard deviations along the axes of W.
struct LeggedEstimatorDiagnostics {
  Vec<3> position_deviation = Vec<3>::Zero();       ///< [m]
  Vec<3> velocity_deviation = Vec<3>::Zero();       ///< of the IMU's place [m/s]
  Vec<3> attitude_deviation = Vec<3>::Zero();       ///< about the axes [rad]
  Vec<3> specific_force_bias_B = Vec<3>::Zero();    ///< estimated [m/s^2]
  Vec<3> angular_velocity_bias_B = Vec<3>::Zero();  ///< estimated [rad/s]
  int feet = 0;                                     ///< that count
  long moved_feet = 0;  ///< since the start: how often a standing foot was anchored anew

  static FieldList Fields() {
    using D = LeggedEstimatorDiagnostics;
    return {{"position_deviation", &D::position_deviation, "m"},
            {"velocity_deviation", &D::velocity_deviation, "m/s"},
            {"attitude_deviation", &D::attitude_deviation, "rad"},
            {"specific_force_bias_B", &D::specific_force_bias_B, "m/s^2"},
            {"angular_velocity_bias_B", &D::angular_velocity_bias_B, "rad/s"},
            {"feet", &D::feet},
            {"moved_feet", &D::moved_feet}};
  }
};

struct LeggedEstimate {
  LeggedState state;
  LeggedEstimatorDiagnostics diagnostics;

  static FieldList Fields() {
    return {{"state", &LeggedEstimate::state}, {"diagnostics", &LeggedEstimate::diagnostics}};
  }
};

/// The trunk's pose and velocity from IMU, encoders and the knowledge which feet stand: ContactAidedFilter
/// with a quadruped's kinematics. Joint angles and speeds are passed on as the encoders give them; the
/// angular velocity is the gyroscope's without its estimated bias.
///
/// The IMU's sample of a tick is used at the next one, to go from the one to the other: it feels the torque
/// that follows from this very estimate. The angular velocity so is one tick old.
///
/// Feet roll with the radius that is left when the robot's weight, shared by those that count, has pressed
/// them into the ground, foot_radius - m g / (n k) - b / 2 with the contact's stiffness k and blend b.
/// A foot counts once it has been in stance for `settle_time`, when the ground below has taken its load; in
/// swing, late or searching it does not.
///
///     | port        | kind            | type                        |
///     | imu         | input           | ImuMeasurement              |
///     | joints      | input           | JointMotion                 |
///     | schedule    | input           | ContactSchedule             |
///     | ground      | input           | GroundPlane; level if not connected |
///     | estimate    | output, sampled | LeggedEstimate              |
///     | state       | output          | LeggedState, of estimate    |
///     | diagnostics | output          | LeggedEstimatorDiagnostics  |
///     | inertial    | output          | ImuMeasurement, without the estimated biases |
///     | noise       | parameter       | ContactAidedNoise           |
///     | settle_time | parameter       | double [s]                  |
///     | outlier     | parameter       | double                      |
class LeggedStateEstimator final : public LeafSystem<LeggedStateEstimatorParams> {
 public:
  using LeafSystem::LeafSystem;

  /// What the estimator remembers.
  struct Memory {
    bool started = false;
    ContactAidedFilter filter;
    Vec<12> q = Vec<12>::Zero();                 ///< joint angles of the last tick [rad]
    std::array<double, kNumLegs> stance_time{};  ///< since touchdown [s]
    long moved_feet = 0;

    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"filter", &Memory::filter},
              {"q", &Memory::q, "rad", kJointElements},
              {"stance_time", &Memory::stance_time, "s", kLegElements},
              {"moved_feet", &Memory::moved_feet}};
    }
  };

  InputPort<ImuMeasurement> imu{this, {"imu"}};
  InputPort<JointMotion> joints{this, {"joints"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  Parameter<ContactAidedNoise> noise{
      this, {"noise"}, params.noise, "standard deviations that the filter believes in"};
  Parameter<double> settle_time{
      this, {"settle_time", "s"}, params.settle_time, "a foot counts once it has been in stance so long"};
  Parameter<double> outlier{
      this, {"outlier"}, params.outlier, "squared Mahalanobis distance above which a foot has moved"};
  Scratch<Memory> memory{this, "memory"};

 private:
  QuadrupedModel model_{params.robot, params.gravity};
  DiscreteState<ImuMeasurement> last_imu_{this, {"last_imu"}};
  Update<ImuMeasurement> next_imu_{last_imu_, Sampled{params.rate}, Uses(imu),
                                   [](const ImuMeasurement& imu) -> const ImuMeasurement& { return imu; }};
  Shared<QuadrupedDynamics> legs_{this, "legs", Uses(joints), &LeggedStateEstimator::CalcLegs};

 public:
  OutputPort<LeggedEstimate> estimate{
      this,
      {"estimate"},
      Sampled{params.rate},
      Uses(last_imu_, legs_, joints, schedule, ground, noise, settle_time, outlier, memory),
      &LeggedStateEstimator::CalcEstimate};
  OutputPort<LeggedState> state{
      this, {"state"}, Uses(estimate), [](const LeggedEstimate& estimate) { return estimate.state; }};
  OutputPort<LeggedEstimatorDiagnostics> diagnostics{
      this, {"diagnostics"}, Uses(estimate), [](const LeggedEstimate& estimate) {
        return estimate.diagnostics;
      }};
  OutputPort<ImuMeasurement> inertial{
      this, {"inertial"}, Uses(imu, diagnostics), &LeggedStateEstimator::CalcInertial};

 private:
  void CalcLegs(const JointMotion& joints, QuadrupedDynamics* legs) const;
  LeggedEstimate CalcEstimate(const ImuMeasurement& last_imu, const QuadrupedDynamics& legs,
                              const JointMotion& joints, const ContactSchedule& schedule,
                              const GroundPlane& ground, const ContactAidedNoise& noise, double settle_time,
                              double outlier, Memory& memory) const;
  ImuMeasurement CalcInertial(const ImuMeasurement& imu, const LeggedEstimatorDiagnostics& diagnostics) const;
  double RollingRadius(const std::array<bool, kNumLegs>& anchored) const;
  void Start(const JointMotion& joints, double settle_time, Memory& memory) const;
  LeggedEstimate Output(const ImuMeasurement& imu_B, const JointMotion& joints, const Memory& memory) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::LeggedEstimate);
TENON_DECLARE_SIGNAL(tenon::LeggedEstimatorDiagnostics);
