#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/plants/signals/quaternion.h>

namespace tenon {

/// Noise model of ContactAidedFilter: standard deviations per axis.
struct ContactAidedNoise {
  double specific_force = 0.05;              ///< white, per sample [m/s^2]
  double angular_velocity = 0.005;           ///< white, per sample [rad/s]
  double specific_force_bias_walk = 1e-4;    ///< [m/s^2 after 1 s, growing with sqrt(t)]
  double angular_velocity_bias_walk = 1e-5;  ///< [rad/s after 1 s, growing with sqrt(t)]
  double encoder = 1e-4;                     ///< white, per sample [rad]
  double foot = 5e-4;                        ///< foot position by the leg's kinematics, white, per sample [m]
  double foot_walk = 2e-3;                   ///< drift of a stance foot [m after 1 s, growing with sqrt(t)]

  static FieldList Fields() {
    using N = ContactAidedNoise;
    FieldList fields{{"specific_force", &N::specific_force, "m/s^2"},
                     {"angular_velocity", &N::angular_velocity, "rad/s"},
                     {"specific_force_bias_walk", &N::specific_force_bias_walk, "m/s^2/sqrt(s)"},
                     {"angular_velocity_bias_walk", &N::angular_velocity_bias_walk, "rad/s/sqrt(s)"},
                     {"encoder", &N::encoder, "rad"},
                     {"foot", &N::foot, "m"},
                     {"foot_walk", &N::foot_walk, "m/sqrt(s)"}};
    for (Field& field : fields) field.Positive().Because("use a small value for a perfect sensor");
    return fields;
  }
};

/// Mean of the estimate. I is the IMU's frame, with the trunk's axes; W is the world, z up.
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

/// Inputs of one prediction step.
struct ContactAidedInput {
  ImuMeasurement inertial;  ///< at the start of the interval, in the trunk's axes
  std::array<Vec<3>, kNumLegs>
      turn_B;                ///< rotation of the shanks relative to the trunk, as rotation vectors [rad]
  Vec<3> normal_W{0, 0, 1};  ///< unit normal of the ground
};

/// Position of a foot from its leg's joint angles.
struct FootMeasurement {
  Vec<3> p_IF_B;               ///< centre of the foot's sphere from the IMU, in the trunk's axes [m]
  Eigen::Matrix3d covariance;  ///< [m^2]
};

/// Extended Kalman filter on IMU and leg kinematics (Bloesch et al. 2012, "State estimation for legged
/// robots: consistent fusion of leg kinematics and IMU"). The positions of stance feet are part of the state,
/// so that a stance foot measures the trunk's motion and not its absolute position. With f = f_read - b_f, w
/// = w_read - b_w, period T and a = R f + g, the prediction is
///
///     p += T v + T^2/2 a,   v += T a,   R <- R exp([T w]x),   p_i += rho (R (T w + turn_i)) x n
///
/// The last equation states that a stance foot, a sphere of radius rho on ground with normal n, rolls with
/// its shank: its contact point is at rest, not its centre. An anchored foot is measured by
///
///     0 = p_i - p - R y_i + noise,   y_i the place from the joints;
///
/// and other feet are not part of the estimate and have no covariance.
///
/// The error (xi_p, xi_v, theta, db_f, db_w, xi_1 ... xi_4) is the right-invariant one of Hartley et al.
/// 2020, "Contact-aided invariant extended Kalman filtering": with E = exp([theta]x),
///
///     R = E R_hat,   p = E p_hat + xi_p,   v = E v_hat + xi_v,   p_i = E p_hat_i + xi_i,   b = b_hat + db.
///
/// With this error the measurement is linear, and the unobservable position and yaw stay unobservable. With
/// the plain difference as error, the filter underestimates its velocity deviation by a factor of 1.6 after a
/// start with a tilt error of 1 degree. The height of the ground is unknown; the errors of position and yaw
/// grow slowly.
struct ContactAidedFilter {
  static constexpr int kPosition = 0, kVelocity = 3, kAttitude = 6, kForceBias = 9, kRateBias = 12,
                       kFeet = 15, kErrors = kFeet + 3 * kNumLegs;
  using Error = Eigen::Matrix<double, kErrors, 1, Eigen::DontAlign>;
  using Covariance = Eigen::Matrix<double, kErrors, kErrors, Eigen::DontAlign>;
  using FootRow = Eigen::Matrix<double, 3, kErrors, Eigen::DontAlign>;

  ContactAidedMean mean;
  Covariance covariance = Covariance::Zero();
  std::array<bool, kNumLegs> anchored{};

  /// Starts with uncorrelated errors of p, v, attitude, b_f and b_w with these standard deviations, and no
  /// anchored foot.
  void Start(const ContactAidedMean& mean, const Eigen::Matrix<double, 5, 1>& deviation);
  /// Covariances of p - p_hat [m^2] and v - v_hat [m^2/s^2].
  Eigen::Matrix3d PositionCovariance() const { return PlainCovariance(kPosition, mean.p_WI); }
  Eigen::Matrix3d VelocityCovariance() const { return PlainCovariance(kVelocity, mean.v_WI); }
  /// Advances the estimate by the period T [s].
  void Predict(const ContactAidedInput& input, const ContactAidedNoise& noise, double T, double radius,
               double gravity);
  /// Adds a foot to the estimate, at the measured position.
  void Anchor(int leg, const FootMeasurement& foot);
  /// Removes a foot from the estimate.
  void Release(int leg);
  /// Corrects the estimate by all anchored feet. A foot whose squared Mahalanobis distance exceeds `outlier`
  /// has slipped or was lifted and is anchored again at its measured position. Returns the number of such
  /// feet.
  int Correct(const std::array<FootMeasurement, kNumLegs>& feet, double outlier);

  static FieldList Fields() {
    return {{"mean", &ContactAidedFilter::mean},
            {"covariance", &ContactAidedFilter::covariance},
            {"anchored", &ContactAidedFilter::anchored, "", kLegElements}};
  }

 private:
  Eigen::Matrix3d PlainCovariance(int rows, const Vec<3>& value) const;
};

/// The mean corrected by an error, see ContactAidedFilter.
ContactAidedMean Plus(const ContactAidedMean& mean, const ContactAidedFilter::Error& error);
/// The mean after one period T [s]. Feet that are not `anchored` do not move.
ContactAidedMean Propagate(const ContactAidedMean& mean, const ContactAidedInput& input,
                           const std::array<bool, kNumLegs>& anchored, double T, double radius,
                           double gravity);
/// Derivative of the error after Propagate() with respect to the error before, to second order in T w; zero
/// rows for feet that are not `anchored`.
ContactAidedFilter::Covariance PropagationJacobian(const ContactAidedMean& mean,
                                                   const ContactAidedInput& input,
                                                   const std::array<bool, kNumLegs>& anchored, double T,
                                                   double radius, double gravity);
/// p_i - p - R y [m]. Where it is 0, its derivative with respect to the error equals that of xi_i - xi_p.
Vec<3> FootResidual(const ContactAidedMean& mean, int leg, const Vec<3>& p_IF_B);

}  // namespace tenon
