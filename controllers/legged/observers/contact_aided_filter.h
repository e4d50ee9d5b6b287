#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/plants/signals/quaternion.h>
#include <tenon/systems/framework/types/fields.h>

#include <Eigen/Core>

#include <array>

namespace tenon {

/// What the filter believes of its sensors and of the ground, as standard deviations per axis.
struct ContactAidedNoise {
  double specific_force = 0.05;              ///< white, per sample [m/s^2]
  double angular_velocity = 0.005;           ///< white, per sample [rad/s]
  double specific_force_bias_walk = 1e-4;    ///< [m/s^2 after 1 s, growing with sqrt(t)]
  double angular_velocity_bias_walk = 1e-5;  ///< [rad/s after 1 s, growing with sqrt(t)]
  double encoder = 1e-4;                     ///< white, per sample [rad]
  double foot = 5e-4;       ///< of a foot's place against the leg's kinematics, white, per sample [m]
  double foot_walk = 2e-3;  ///< what a standing foot wanders [m after 1 s, growing with sqrt(t)]

  static FieldList Fields() {
    using N = ContactAidedNoise;
    return {{"specific_force", &N::specific_force, "m/s^2"},
            {"angular_velocity", &N::angular_velocity, "rad/s"},
            {"specific_force_bias_walk", &N::specific_force_bias_walk, "m/s^2/sqrt(s)"},
            {"angular_velocity_bias_walk", &N::angular_velocity_bias_walk, "rad/s/sqrt(s)"},
            {"encoder", &N::encoder, "rad"},
            {"foot", &N::foot, "m"},
            {"foot_walk", &N::foot_walk, "m/sqrt(s)"}};
  }
  /// Throws ParameterError unless the deviations are finite and positive (a perfect sensor has a small one).
  void Validate() const;
};

/// Mean of the estimate. I is where the IMU sits, with the trunk's axes; W is the world, z up.
struct ContactAidedMean {
  Vec<3> p_WI = Vec<3>::Zero();                     ///< [m]
  Vec<3> v_WI = Vec<3>::Zero();                     ///< [m/s]
  Vec<4> q_WB{1, 0, 0, 0};                          ///< attitude, (w, x, y, z)
  Vec<3> specific_force_bias_B = Vec<3>::Zero();    ///< [m/s^2]
  Vec<3> angular_velocity_bias_B = Vec<3>::Zero();  ///< [rad/s]
  /// Centres of the feet's spheres [m].
  std::array<Vec<3>, kNumLegs> feet_W{Vec<3>::Zero(), Vec<3>::Zero(), Vec<3>::Zero(), Vec<3>::Zero()};

  Eigen::Matrix3d R_WB() const { return RotationFromQuaternion(q_WB); }
  static FieldList Fields() {
    return {{"p_WI", &ContactAidedMean::p_WI, "m"},
            {"v_WI", &ContactAidedMean::v_WI, "m/s"},
            {"q_WB", &ContactAidedMean::q_WB, "", "w,x,y,z"},
            {"specific_force_bias_B", &ContactAidedMean::specific_force_bias_B, "m/s^2"},
            {"angular_velocity_bias_B", &ContactAidedMean::angular_velocity_bias_B, "rad/s"},
            {"feet_W", &ContactAidedMean::feet_W, "m", kLegElements}};
  }
};

/// What one tick brings, besides its length.
struct ContactAidedInput {
  ImuMeasurement inertial;              ///< at the beginning of the interval, in the trunk's axes
  std::array<Vec<3>, kNumLegs> turn_B;  ///< of the shanks against the trunk, as rotation vectors [rad]
  Vec<3> normal_W{0, 0, 1};             ///< of the ground
};

/// Where a foot is, from its leg's joints.
struct FootMeasurement {
  Vec<3> p_IF_B;               ///< from the IMU to the centre of the sphere, in the trunk's axes [m]
  Eigen::Matrix3d covariance;  ///< [m^2]
};

/// Kalman filter on IMU and legs: Bloesch et al. 2012, "State estimation for legged robots: consistent fusion
/// of leg kinematics and IMU", in which places of standing feet are part of the state, so that a foot which
/// stands still tells of the trunk's motion and not of its place. With f = f_read - b_f, w = w_read - b_w,
/// period T and a = R f + g, one tick is
///
///     p += T v + T^2/2 a,   v += T a,   R <- R exp([T w]x),   p_i += rho (R (T w + turn_i)) x n
///
/// The last says that a standing foot, a sphere of radius rho on ground with the normal n, rolls with its
/// shank: it is the point in contact that stands still and not the centre. A foot that is anchored is
/// measured by
///
///     0 = p_i - p - R y_i + noise,   y_i the place from the joints;
///
/// a foot that is not has no part in the estimate, and no covariance.
///
/// The error (xi_p, xi_v, theta, db_f, db_w, xi_1 ... xi_4) is the right-invariant one of Hartley et al.
/// 2020, "Contact-aided invariant extended Kalman filtering": with E = exp([theta]x),
///
///     R = E R_hat,   p = E p_hat + xi_p,   v = E v_hat + xi_v,   p_i = E p_hat_i + xi_i,   b = b_hat + db.
///
/// In it the measurement is linear, and what cannot be seen, position and yaw, stays so: with plain
/// differences the filter thinks its velocity 1.6 times as good as it is after a start with 1 degree of tilt.
/// Nothing is known of the height of the ground; the errors of position and yaw grow, slowly.
struct ContactAidedFilter {
  static constexpr int kPosition = 0, kVelocity = 3, kAttitude = 6, kForceBias = 9, kRateBias = 12,
                       kFeet = 15, kErrors = kFeet + 3 * kNumLegs;
  using Error = Eigen::Matrix<double, kErrors, 1, Eigen::DontAlign>;
  using Covariance = Eigen::Matrix<double, kErrors, kErrors, Eigen::DontAlign>;
  using FootRow = Eigen::Matrix<double, 3, kErrors, Eigen::DontAlign>;

  ContactAidedMean mean;
  Covariance covariance = Covariance::Zero();
  std::array<bool, kNumLegs> anchored{};

  /// Starts with errors of p, v, attitude and biases that know nothing of each other, with these standard
  /// deviations; no foot is anchored.
  void Start(const ContactAidedMean& mean, const Eigen::Matrix<double, 5, 1>& deviation);
  /// The covariance of p - p_hat [m^2], and that of v - v_hat [m^2/s^2].
  Eigen::Matrix3d PositionCovariance() const { return PlainCovariance(kPosition, mean.p_WI); }
  Eigen::Matrix3d VelocityCovariance() const { return PlainCovariance(kVelocity, mean.v_WI); }
  /// One tick of length T [s] on.
  void Predict(const ContactAidedInput& input, const ContactAidedNoise& noise, double T, double radius,
               double gravity);
  /// From now on the foot stands where the joints say that it is.
  void Anchor(int leg, const FootMeasurement& foot);
  /// The foot leaves the ground, and the estimate.
  void Release(int leg);
  /// Corrects by all anchored feet. One whose squared Mahalanobis distance is above `outlier` has slipped or
  /// was lifted: it is anchored anew where it is. Returns how many.
  int Correct(const std::array<FootMeasurement, kNumLegs>& feet, double outlier);

  static FieldList Fields() {
    return {{"mean", &ContactAidedFilter::mean},
            {"covariance", &ContactAidedFilter::covariance},
            {"anchored", &ContactAidedFilter::anchored, "", kLegElements}};
  }

 private:
  Eigen::Matrix3d PlainCovariance(int rows, const Vec<3>& value) const;
};

/// The mean with an error added, as the error is defined.
ContactAidedMean Plus(const ContactAidedMean& mean, const ContactAidedFilter::Error& error);
/// The mean one tick on. Feet that are not `anchored` stay.
ContactAidedMean Propagate(const ContactAidedMean& mean, const ContactAidedInput& input,
                           const std::array<bool, kNumLegs>& anchored, double T, double radius,
                           double gravity);
/// The derivative of its error by the error before, to second order in T w; feet that are not `anchored` have
/// none.
ContactAidedFilter::Covariance PropagationJacobian(const ContactAidedMean& mean,
                                                   const ContactAidedInput& input,
                                                   const std::array<bool, kNumLegs>& anchored, double T,
                                                   double radius, double gravity);
/// p_i - p - R y; its derivative by the error is that of xi_i - xi_p where it is 0.
Vec<3> FootResidual(const ContactAidedMean& mean, int leg, const Vec<3>& p_IF_B);

}  // namespace tenon
