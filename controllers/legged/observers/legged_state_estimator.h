#pragma once

#include <tenon/controllers/legged/observers/contact_aided_filter.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Standard deviations per axis of the initial state and of the sensors' biases.
struct LeggedStartDeviation {
  double position = 1e-3;               ///< [m]
  double velocity = 1e-3;               ///< [m/s]
  double attitude = 2e-3;               ///< [rad]
  double specific_force_bias = 0.02;    ///< [m/s^2]
  double angular_velocity_bias = 2e-3;  ///< [rad/s]
};

struct LeggedStateEstimatorParams {
  QuadrupedDescription robot;
  LeggedState initial;         ///< initial state
  LeggedStartDeviation start;  ///< accuracy of `initial`
  ContactAidedNoise noise;
  double settle_time = 0.02;  ///< time in stance before a foot is used [s]
  double outlier = 25;  ///< squared Mahalanobis distance (3 degrees of freedom) above which a foot has moved
  double gravity = kGravity;  ///< [m/s^2]
  Rate rate = Hz(1000);       ///< rate of the filter; rates of IMU and encoders should be at least as high

  /// Throws ParameterError unless deviations, noise and `outlier` are finite and positive, `settle_time` is
  /// at least 0, the rest is finite, and initial.q_WB is not zero.
  void Validate() const;
};

/// Diagnostics of LeggedStateEstimator: standard deviations along the axes of W, biases and feet.
struct LeggedEstimatorDiagnostics {
  Vec<3> position_deviation = Vec<3>::Zero();       ///< [m]
  Vec<3> velocity_deviation = Vec<3>::Zero();       ///< deviation of the IMU's velocity [m/s]
  Vec<3> attitude_deviation = Vec<3>::Zero();       ///< rotations about the axes [rad]
  Vec<3> specific_force_bias_B = Vec<3>::Zero();    ///< estimated [m/s^2]
  Vec<3> angular_velocity_bias_B = Vec<3>::Zero();  ///< estimated [rad/s]
  int feet = 0;                                     ///< number of feet in use
  long moved_feet = 0;                              ///< number of outliers since the start

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

/// Estimates the trunk's pose and velocity from IMU, encoders and the contact schedule by ContactAidedFilter.
/// Joint angles and speeds are the encoders' measurements; the angular velocity is the gyroscope's
/// measurement minus its estimated bias.
///
/// The IMU sample of a tick is used at the next tick, for the prediction over the interval between them,
/// since the IMU depends on the torque that follows from this estimate. The estimated angular velocity is
/// therefore one tick old.
///
/// Feet roll with the radius that remains when the robot's weight, shared by n feet, deforms the contacts:
/// foot_radius - m g / (n k) - b / 2 with the contact's stiffness k and blend b. A foot is used after it has
/// been in stance for `settle_time`, when the ground carries its load; feet in swing, late or searching are
/// not used.
class LeggedStateEstimator final : public LeafSystem<LeggedStateEstimatorParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Memory of the estimator.
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
  Parameter<ContactAidedNoise> noise{this, {"noise"}, params.noise, "noise model of the filter"};
  Parameter<double> settle_time{this,
                                {"settle_time", "s"},
                                params.settle_time,
                                "time in stance before a foot is used",
                                Range().AtLeast(0).Because("0 trusts a foot from its touchdown")};
  Parameter<double> outlier{this,
                            {"outlier"},
                            params.outlier,
                            "squared Mahalanobis distance above which a foot has moved",
                            Range().Positive()};
  Scratch<Memory> memory{this, "memory"};

 private:
  QuadrupedModel model_{params.robot, params.gravity};
  DiscreteState<ImuMeasurement> last_imu_{this, {"last_imu"}};
  Update<ImuMeasurement> next_imu_{last_imu_, Sampled{params.rate}, Uses(imu),
                                   [](const ImuMeasurement& now) -> const ImuMeasurement& { return now; }};
  Shared<QuadrupedDynamics> legs_{this, "legs", Uses(joints), &LeggedStateEstimator::CalcLegs};

 public:
  OutputPort<LeggedEstimate> estimate{
      this,
      {"estimate"},
      Sampled{params.rate},
      Uses(last_imu_, legs_, joints, schedule, ground, noise, settle_time, outlier, memory),
      &LeggedStateEstimator::CalcEstimate};
  OutputPort<LeggedState> state{
      this, {"state"}, Uses(estimate), [](const LeggedEstimate& estimate_now) { return estimate_now.state; }};
  OutputPort<LeggedEstimatorDiagnostics> diagnostics{
      this, {"diagnostics"}, Uses(estimate), [](const LeggedEstimate& estimate_now) {
        return estimate_now.diagnostics;
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
