#pragma once

#include <tenon/plants/model/path.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// An estimated state of the platform with its time stamp.
struct PlatformEstimate {
  double time = 0;  ///< [s]
  PlatformState platform;

  static FieldList Fields() {
    return {{"time", &PlatformEstimate::time, "s"}, {"platform", &PlatformEstimate::platform}};
  }
};

/// Standard deviations of the sensor noise in the filter's model, per axis and sample.
struct CdprNoise {
  double position = 0.005;          ///< [m]
  double attitude = 0.01;           ///< [rad]
  double angular_velocity = 0.005;  ///< [rad/s]
  double specific_force = 0.05;     ///< [m/s^2]
  double length_rate = 0.005;       ///< rate of a cable length, mean between samples: 2 % of 0.25 m/s [m/s]

  static FieldList Fields() {
    FieldList fields{{"position", &CdprNoise::position, "m"},
                     {"attitude", &CdprNoise::attitude, "rad"},
                     {"angular_velocity", &CdprNoise::angular_velocity, "rad/s"},
                     {"specific_force", &CdprNoise::specific_force, "m/s^2"},
                     {"length_rate", &CdprNoise::length_rate, "m/s"}};
    for (Field& field : fields) field.Positive().Because("give a perfect sensor a small deviation");
    return fields;
  }
};

struct CdprEstimatorParams {
  CdprDescription robot{};  ///< model of the controller; used only with `cables`
  Rate rate = Hz(200);      ///< rate of pose, IMU and filter
  CdprNoise noise{};
  double initial_velocity = 0.02;  ///< deviation of the velocity at the start from rest [m/s]
  double gravity = kGravity;       ///< [m/s^2]

  static FieldList Fields() {
    using P = CdprEstimatorParams;
    return {Undescribed(&P::robot), Undescribed(&P::rate), Undescribed(&P::noise),
            Undescribed("initial_velocity", &P::initial_velocity).Positive(),
            Undescribed("gravity", &P::gravity).Positive()};
  }
};

/// Estimates pose and velocity of the platform from an IMU, a pose sensor and the cable lengths by an
/// extended Kalman filter on the error (dp, dv, dtheta), R = R_hat exp([dtheta]x).
///
/// Between ticks the mean of the last two IMU samples (w, f) drives the prediction, with T the period:
///
///     a = R f + g,   p += T v + T^2/2 a,   v += T a,   R <- R exp([T w]x)
///     dp' = dp + T dv,   dv' = dv - T R [f]x dtheta,   dtheta' = (1 - T [w]x) dtheta
///
/// At a tick the changes of the lengths l since the last tick correct the velocity, if `cables` is connected,
/// and the pose corrects all states. With v and w the means between the ticks, the model of the lengths is
///
///     (l_i - l_i before) / T = -(W column i) . [v ; R w]      see CableKinematics
///
/// with white noise of `length_rate` and of the gyroscope. Errors by sag, layers on a drum or a broken cable
/// are not white. The filter therefore low-passes the difference of both sides with the time constant
/// t_b = 0.2 s to b_i and adds noise of the variance 2 t_b/T b_i^2, whose mean over t_b is as large as b_i. A
/// cable that contradicts the others and the IMU thus loses its weight. Without lengths the velocity follows
/// from the accelerometer and the differences of the pose.
///
/// The angular velocity is the gyroscope's. The first tick takes the measured pose and assumes the platform
/// at rest. Sensor biases are not estimated.
///
/// The IMU measures the acceleration by any cause, so an unknown load does not disturb the estimate.
class CdprEstimator final : public LeafSystem<CdprEstimatorParams> {
 public:
  using LeafSystem::LeafSystem;
  const MovingAnchors anchors{params.robot};
  using Covariance = Eigen::Matrix<double, 9, 9>;

  /// State of the filter.
  struct Memory {
    bool started = false;
    PlatformState platform;
    ImuMeasurement inertial;
    Covariance covariance = Covariance::Zero();
    CableVector length;  ///< at the last tick [m]
    CableVector bias;    ///< b [m/s]

    static FieldList Fields() {
      return {{"started", &Memory::started},    {"platform", &Memory::platform},
              {"inertial", &Memory::inertial},  {"covariance", &Memory::covariance},
              {"length", &Memory::length, "m"}, {"bias", &Memory::bias, "m/s"}};
    }
  };

  InputPort<PoseMeasurement> pose{this, {"pose"}};
  InputPort<ImuMeasurement> inertial{this, {"inertial"}};
  InputPort<CableSignals> cables{this, {"cables"}, CableSignals{}};
  Parameter<CdprNoise> noise{this, {"noise"}, params.noise, "noise model of the filter"};
  Scratch<Memory> memory{this, "memory", FirstMemory(params)};
  OutputPort<PlatformEstimate> estimate{this,
                                        {"estimate"},
                                        Sampled{params.rate},
                                        Uses(time, pose, inertial, cables, noise, memory),
                                        &CdprEstimator::CalcEstimate};

 private:
  /// Mean motion between two ticks.
  struct Step {
    Eigen::Vector3d p_WB, v_W, w_B;
    Eigen::Matrix3d R_WB;
  };
  static Memory FirstMemory(const CdprEstimatorParams& params);
  PlatformEstimate CalcEstimate(const double& time, const PoseMeasurement& pose,
                                const ImuMeasurement& inertial, const CableSignals& cables,
                                const CdprNoise& noise, Memory& memory) const;
  Step Predict(const ImuMeasurement& inertial, const CdprNoise& noise, Memory& memory) const;
  void CorrectByLengths(double time, const CableVector& length, const CdprNoise& noise, Step mean,
                        Memory& memory) const;
  void Correct(const PoseMeasurement& pose, const CdprNoise& noise, Memory& memory) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::PlatformEstimate);
