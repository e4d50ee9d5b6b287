#pragma once

#include <tenon/controllers/cdpr/cdpr_estimator.h>

namespace tenon {

struct LoadEstimatorParams {
  CdprDescription robot;          ///< model of the controller
  Rate rate = Hz(200);            ///< rate of the estimate and of the inertial unit
  double bandwidth = 20;          ///< bandwidth b of force and torque [rad/s]
  double rest_bandwidth = 5;      ///< bandwidth b_r of the remaining wrench [rad/s]
  double mass_bandwidth = 100;    ///< bandwidth b_m of the payload's mass [rad/s]
  double least_mass = 0.05;       ///< dead band of the payload's mass, relative to the platform's mass
  double arm_deviation = 0.5;     ///< initial standard deviation of the payload's position [m]
  double torque_deviation = 0.5;  ///< noise of the torque from which the position is estimated [N m]
  double arm_walk = 0.05;         ///< process noise of the payload's position [m/sqrt(s)]

  static FieldList Fields() {
    using P = LoadEstimatorParams;
    return {Undescribed(&P::robot),
            Undescribed(&P::rate),
            Undescribed(&P::bandwidth),
            Undescribed("rest_bandwidth", &P::rest_bandwidth).Positive(),
            Undescribed("mass_bandwidth", &P::mass_bandwidth).Positive(),
            Undescribed("least_mass", &P::least_mass).Positive(),
            Undescribed("arm_deviation", &P::arm_deviation).Positive(),
            Undescribed("torque_deviation", &P::torque_deviation).Positive(),
            Undescribed("arm_walk", &P::arm_walk).Positive()};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Estimates the load on the platform besides gravity, cables and springs, split into a point mass that it
/// carries and a remaining wrench, from the inertial unit, the measured tensions u and the estimated pose. W
/// is the structure matrix at that pose, h the period and LP a first-order low-pass filter with the bandwidth
/// b:
///
///     force   F = LP(m R f_B - (W u)_f)                   by Newton, f_B the specific force R^T (a - g)
///     torque  tau = b (I_W w - s),  s' = (W u)_tau + tau  observer of the momentum I_W w, Euler's steps
///     place   r of R r x F = tau, by a Kalman filter of a random walk: the part along F shows when the
///             platform turns
///     mass    m_L of F = -m_L y, by a low-pass of bandwidth b_m,
///             y = LP(R f_B) + alpha x R r + w x (w x R r),   alpha = LP(w')
///     rest    F + m_L y and tau + R r x m_L y, by a low-pass of bandwidth b_r
///
/// A point mass exerts only a force at its place. With exact tensions, masses and inertias, a point mass and
/// a constant wrench are therefore found without error at rest, and in motion up to the rotation of the
/// platform during the lag of the filters. A mass below the dead band is part of the rest. A known wrench is
/// added to W u and, without lag, to the rest; that of the robot's springs is added to W u.
class LoadEstimator final : public LeafSystem<LoadEstimatorParams> {
 public:
  using LeafSystem::LeafSystem;
  const MovingAnchors anchors{params.robot};

  struct Memory {
    bool started = false;
    Vec<3> force_W = Vec<3>::Zero();             ///< F [N]
    Vec<3> momentum_W = Vec<3>::Zero();          ///< s [N m s]
    Vec<3> specific_force_W = Vec<3>::Zero();    ///< LP(R f_B) [m/s^2]
    Vec<3> angular_velocity_W = Vec<3>::Zero();  ///< LP(w) [rad/s]
    Vec<3> arm_B = Vec<3>::Zero();               ///< r [m]
    Vec<9> arm_covariance = Vec<9>::Zero();      ///< [m^2]
    double mass = 0;                             ///< m_L [kg]
    PlatformWrench rest;
    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"force_W", &Memory::force_W, "N"},
              {"momentum_W", &Memory::momentum_W, "N m s"},
              {"specific_force_W", &Memory::specific_force_W, "m/s^2"},
              {"angular_velocity_W", &Memory::angular_velocity_W, "rad/s"},
              {"arm_B", &Memory::arm_B, "m"},
              {"arm_covariance", &Memory::arm_covariance, "m^2"},
              {"mass", &Memory::mass, "kg"},
              {"rest", &Memory::rest}};
    }
  };

  InputPort<PlatformEstimate> estimate{this, {"estimate"}};
  InputPort<ImuMeasurement> inertial{this, {"inertial"}};
  InputPort<CableSignals> cables{this, {"cables"}};
  InputPort<PlatformWrench> known_wrench{this, {"known_wrench"}, PlatformWrench{}};
  Parameter<double> bandwidth{this,
                              {"bandwidth", "rad/s"},
                              params.bandwidth,
                              "bandwidth of the estimated force and torque",
                              Range().Positive()};
  Scratch<Memory> memory{this, "memory"};
  OutputPort<LoadEstimate> load{this,
                                {"load"},
                                Sampled{params.rate},
                                Uses(estimate, inertial, cables, known_wrench, bandwidth, memory),
                                &LoadEstimator::CalcLoad};

 private:
  LoadEstimate CalcLoad(const PlatformEstimate& estimate, const ImuMeasurement& inertial,
                        const CableSignals& cables, const PlatformWrench& known, double bandwidth,
                        Memory& memory) const;
  void CorrectArm(const Eigen::Vector3d& force_B, const Eigen::Vector3d& torque_B, Memory& memory) const;
};

}  // namespace tenon
