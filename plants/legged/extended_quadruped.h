#pragma once

#include <tenon/plants/legged/quadruped_body.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/geometry.h>

#include <Eigen/Core>

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace tenon {

class QuadrupedMultibody;

/// Adds to a quadruped's multibody system, see quadruped_multibody.h.
using ExtendQuadruped = std::function<void(QuadrupedMultibody&)>;

/// Accelerations of an extended quadruped, and rates of the added states.
struct ExtendedRates {
  LeggedAcceleration robot;
  Eigen::VectorXd q, u, z;
};

/// A quadruped with additions, whose equations of motion are those of Simbody's System.
///
/// Simbody's forward dynamics give the accelerations u0 with all forces and constraints of the System. Two
/// effects are added to them. Joints of Simbody have no rotors, whose inertia D is on the diagonal of the
/// mass matrix M. And constraints hold for accelerations alone, so the errors of integration would
/// accumulate: errors of position p and of velocity v decay like critically damped oscillators with the rate
/// a = 50 /s. With the Jacobian G of the constraints,
///
///     (M + D) d + G^T l = -D u0,   G d = -2 a v - a^2 p,   u' = u0 + d.
///
/// A System with force elements must not be used in two threads at once, not even with two States. Each copy
/// therefore builds its own System: the function is called once for each copy, in one thread at a time.
class ExtendedQuadruped {
 public:
  /// Names, units (both as in Spec) and initial values of added states.
  struct States {
    std::string elements, units;
    Eigen::VectorXd initial;
  };
  struct Additions {
    States q, u, z;           ///< coordinates, speeds, and auxiliary states of force elements
    std::string force_units;  ///< of generalised forces, in the order of u
    Geometry shapes;
  };

  /// No robot: only `exists` and `additions` may be called.
  ExtendedQuadruped();
  /// No robot if `extend` is empty. The initial values of the added coordinates and speeds meet the
  /// constraints in the robot's initial state. Throws ParameterError if there are none, and with Simbody's
  /// message if Simbody refuses the additions.
  ExtendedQuadruped(const QuadrupedDescription& robot, double gravity, const ExtendQuadruped& extend,
                    const LeggedState& initial);
  ExtendedQuadruped(const ExtendedQuadruped& other);
  ExtendedQuadruped& operator=(const ExtendedQuadruped& other);
  ExtendedQuadruped(ExtendedQuadruped&& other);
  ExtendedQuadruped& operator=(ExtendedQuadruped&& other);
  ~ExtendedQuadruped();

  bool exists() const { return model_ != nullptr; }
  const Additions& additions() const;

  /// Sets the state of all functions below. Quaternions may have any non-zero length.
  void SetState(double time, const LeggedState& x, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                const Eigen::VectorXd& z);
  /// Rates under torques on the robot's joints, forces on its bodies, and generalised forces on the added
  /// joints. Throws RunError if Simbody fails.
  void CalcRates(const Vec<12>& torque, std::span<const PointForce> forces, const Eigen::VectorXd& added,
                 ExtendedRates* rates) const;
  /// Rate of the momentum of the robot's own bodies about a point that is fixed in W, at their accelerations.
  /// A replaced part of the trunk counts as fixed to it, see QuadrupedMultibody::Replace.
  WrenchEstimate MomentumRate(const LeggedAcceleration& acceleration, const Vec<3>& p_W) const;
  double KineticEnergy() const;    ///< rotors included [J]
  double PotentialEnergy() const;  ///< gravity, 0 at z = 0, and conservative force elements [J]
  /// Moves Additions::shapes, which begin at `first`.
  void MoveShapes(std::size_t first, Geometry* geometry) const;

 private:
  struct Recipe;
  struct Model;
  std::shared_ptr<const Recipe> recipe_;
  std::unique_ptr<Model> model_;
};

}  // namespace tenon
