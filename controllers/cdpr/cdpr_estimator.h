#pragma once

#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/model/gravity.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

/// A platform's state as it is believed to have been at a time.
struct PlatformEstimate {
  double time = 0;  ///< [s]
  PlatformState platform;

  static FieldList Fields() {
    return {{"time", &PlatformEstimate::time, "s"}, {"platform", &PlatformEstimate::platform}};
  }
};

/// What the filter believes of its sensors, as standard deviations per axis and sample.
struct CdprNoise {
  double position = 0.005;          ///< [m]
  double attitude = 0.01;           ///< [rad]
  double angular_velocity = 0.005;  ///< [rad/s]
  double specific_force = 0.05;     ///< [m/s^2]
  double length_rate = 0.005;       ///< of a cable, mean between two samples: 2 % of 0.25 m/s [m/s]

  static FieldList Fields() {
    return {{"position", &CdprNoise::position, "m"},
            {"attitude", &CdprNoise::attitude, "rad"},
            {"angular_velocity", &CdprNoise::angular_velocity, "rad/s"},
            {"specific_force", &CdprNoise::specific_force, "m/s^2"},
            {"length_rate", &CdprNoise::length_rate, "m/s"}};
  }
};

struct CdprEstimatorParams {
  CdprDescription robot{};  ///< what the controller believes; for `cables` alone
  Rate rate = Hz(200);      ///< of pose, IMU and filter
  CdprNoise noise{};
  double initial_velocity = 0.02;  ///< deviation of the velocity at the start from rest [m/s]
  double gravity = kGravity;       ///< [m/s^2]

  /// Throws ParameterError unless the deviations are positive (a perfect sensor has a small one).
  void Validate() const;
};

/// Where the platform is and how it moves, from an IMU, a pose sensor and the cables' lengths: an extended
/// Kalman filter on the error (dp, dv, dtheta), R = R_hat exp([dtheta]x).
///
/// Between ticks the mean of the last two IMU samples (w, f) drives the prediction, with T the period:
///
///     a = R f + g,   p += T v + T^2/2 a,   v += T a,   R <- R exp([T w]x)
///     dp' = dp + T dv,   dv' = dv - T R [f]x dtheta,   dtheta' = (1 - T [w]x) dtheta
///
/// At a tick the lengths l, if they are connected, correct the velocity by how they changed since the last
/// one, and the pose corrects all. With v and w the means in between,
///
///     (l_i - l_i before) / T = -(W column i) . [v ; R w]      see CableKinematics
///
/// to within `length_rate` and what the gyroscope leaves, taken for white noise. What sag, layers on a
/// drum or a broken cable do to a length is not: b_i, the mean of the difference of both sides over the
/// last t_b = 0.2 s (a low-pass of first order), counts as additional noise of the variance 2 t_b/T b_i^2, of
/// which means over that time would be as large. A cable that disagrees with the others and the IMU so loses
/// its weight; without lengths the velocity is known to what the accelerometer and differences of the pose
/// tell.
///
/// The angular velocity is the gyroscope's. At the first tick the pose is taken as it is and the platform as
/// at rest. No bias of a sensor is estimated.
///
/// The IMU measures whatever accelerates the platform, so an unknown load does not disturb the estimate.
///
///     ports in  pose, inertial
///               cables          for their lengths; none if not connected
///     port out  estimate        sampled
///     parameter noise           CdprNoise
class CdprEstimator final : public LeafSystem<CdprEstimatorParams> {
 public:
  using LeafSystem::LeafSystem;
  using Covariance = Eigen::Matrix<double, 9, 9>;

  /// What the filter remembers.
  struct Memory {
    bool started = false;
    PlatformState platform;
    ImuMeasurement inertial;
    Covariance covariance = Covariance::Zero();
    CableVector length;  ///< a period ago [m]
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
  Parameter<CdprNoise> noise{
      this, {"noise"}, params.noise, "standard deviations that the filter believes in"};
  Scratch<Memory> memory{this, "memory", FirstMemory(params)};
  OutputPort<PlatformEstimate> estimate{this,
                                        {"estimate"},
                                        Sampled{params.rate},
                                        Uses(time, pose, inertial, cables, noise, memory),
                                        &CdprEstimator::CalcEstimate};

 private:
  /// The mean of the motion between two ticks.
  struct Step {
    Eigen::Vector3d p_WB, v_W, w_B;
    Eigen::Matrix3d R_WB;
  };
  static Memory FirstMemory(const CdprEstimatorParams& params);
  PlatformEstimate CalcEstimate(const double& time, const PoseMeasurement& pose,
                                const ImuMeasurement& inertial, const CableSignals& cables,
                                const CdprNoise& noise, Memory& memory) const;
  Step Predict(const ImuMeasurement& inertial, const CdprNoise& noise, Memory& memory) const;
  void CorrectByLengths(const CableVector& length, const CdprNoise& noise, Step mean, Memory& memory) const;
  void Correct(const PoseMeasurement& pose, const CdprNoise& noise, Memory& memory) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::PlatformEstimate);
