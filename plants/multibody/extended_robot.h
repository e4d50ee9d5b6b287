#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/multibody/point_force.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/geometry.h>

#include <functional>

namespace tenon {

class RobotMultibody;

/// Source of the accelerations of a robot without additions: the equations of its plant, or the forward
/// dynamics of Simbody. A plant takes Simbody's if its `extend` is a function, even one that adds nothing.
enum class Dynamics { kClosedForm, kSimbody };

/// Rates of the added states.
struct AddedRates {
  Eigen::VectorXd q, u, z;
};

/// A robot with additions, whose equations of motion are those of Simbody's System.
///
/// Simbody's forward dynamics give the accelerations u0 with all forces and constraints of the System. Three
/// effects are added to them. Joints of Simbody have no rotors, and masses of Simbody cannot change in a run;
/// the inertia D of rotors and payloads is therefore added to the mass matrix M. And constraints hold for
/// accelerations alone, so the errors of integration would accumulate: errors of position p and of velocity v
/// decay like critically damped oscillators with the rate a = 50 /s. With the Jacobian G of the constraints,
///
///     (M + D) d + G^T l = -D u0,   G d = -2 a v - a^2 p,   u' = u0 + d.
///
/// A System with force elements must not be used in two threads at once, not even with two States. Each copy
/// therefore builds its own System: `extend` is called once for each copy, in one thread at a time.
class ExtendedRobot {
 public:
  /// Makes the robot without additions.
  using Make = std::function<std::unique_ptr<RobotMultibody>()>;
  using Extend = std::function<void(RobotMultibody&)>;

  /// A state or an input port of the plant.
  struct Added {
    Spec spec;
    Eigen::VectorXd initial{};  ///< initial value of the state, or default of the port
  };
  /// The states and ports that plants have for their additions, without elements if nothing is added.
  struct Additions {
    Added q{"added_q"}, u{"added_u"};  ///< coordinates and speeds
    Added z{"added_z"};                ///< auxiliary states of force elements
    Added forces{"added_forces"};      ///< generalised forces, in the order of u
    /// References of drives, see RobotMultibody::AddReference; a position of NaN is not connected.
    Added position_references{"added_position_references"}, speed_references{"added_speed_references"};
    Geometry shapes;
    RigidInertia replaced;  ///< part of the base that additions replace, see RobotMultibody::Replace
  };
  /// Motion of the robot's own bodies: pose and velocity of the base, angles and speeds of the joints.
  struct Motion {
    PlatformState base;  ///< the quaternion may have any non-zero length
    std::span<const double> q{}, u{};
  };

  /// No robot: only `exists` and `additions` may be called.
  ExtendedRobot();
  /// The initial values of the added coordinates and speeds meet the constraints in the robot's initial
  /// motion. Throws ParameterError if there are none, and with Simbody's message if Simbody refuses the
  /// additions.
  ExtendedRobot(Make make, Extend extend, double rotor_inertia, const Motion& initial);
  ExtendedRobot(const ExtendedRobot& other);
  ExtendedRobot& operator=(const ExtendedRobot& other);
  ExtendedRobot(ExtendedRobot&& other);
  ExtendedRobot& operator=(ExtendedRobot&& other);
  ~ExtendedRobot();

  bool exists() const { return model_ != nullptr; }
  const Additions& additions() const;

  /// Sets the state of all functions below. Throws RunError if a size is wrong.
  void SetState(double time, const Motion& robot, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                const Eigen::VectorXd& z, const Eigen::VectorXd& position_references,
                const Eigen::VectorXd& speed_references);
  /// Computes the angular and linear acceleration of the base and those of the joints, and the rates of the
  /// added states, under torques on the robot's joints, forces on its bodies, and generalised forces on the
  /// added joints. `payload` is the spatial inertia of masses that are fixed to the base, in W about its
  /// origin, angular before linear; their weight and centrifugal force belong to `forces`. Throws RunError if
  /// Simbody fails, or if the number of added forces is wrong.
  void CalcRates(std::span<const double> torque, std::span<const PointForce> forces,
                 const Eigen::VectorXd& added, const Eigen::Matrix<double, 6, 6>& payload,
                 Eigen::VectorXd* robot, AddedRates* rates) const;
  /// Rate of the momentum of the robot's own bodies about a point that is fixed in W, at accelerations as
  /// CalcRates returns them. A replaced part of the base counts as fixed to it, see RobotMultibody::Replace.
  PlatformWrench MomentumRate(const Eigen::VectorXd& robot, const Vec<3>& p_W) const;
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
