#pragma once

#include <tenon/plants/signals/leg.h>
#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Reference of CoM and trunk. W is the world, z up; B is fixed to the trunk.
struct BodyReference {
  Vec<3> com_W = Vec<3>::Zero();               ///< centre of mass [m]
  Vec<3> com_velocity_W = Vec<3>::Zero();      ///< [m/s]
  Vec<3> com_acceleration_W = Vec<3>::Zero();  ///< [m/s^2]
  Vec<4> q_WB{1, 0, 0, 0};                     ///< attitude, (w, x, y, z)
  Vec<3> w_W = Vec<3>::Zero();                 ///< angular velocity [rad/s]
  Vec<3> alpha_W = Vec<3>::Zero();             ///< angular acceleration [rad/s^2]

  static FieldList Fields() {
    return {{"com_W", &BodyReference::com_W, "m"},
            {"com_velocity_W", &BodyReference::com_velocity_W, "m/s"},
            {"com_acceleration_W", &BodyReference::com_acceleration_W, "m/s^2"},
            {"q_WB", &BodyReference::q_WB, "", "w,x,y,z"},
            {"w_W", &BodyReference::w_W, "rad/s"},
            {"alpha_W", &BodyReference::alpha_W, "rad/s^2"}};
  }
};

/// Reference of the centre of a foot's sphere.
struct FootReference {
  Vec<3> p_W = Vec<3>::Zero();  ///< [m]
  Vec<3> v_W = Vec<3>::Zero();  ///< [m/s]
  Vec<3> a_W = Vec<3>::Zero();  ///< [m/s^2]

  static FieldList Fields() {
    return {{"p_W", &FootReference::p_W, "m"},
            {"v_W", &FootReference::v_W, "m/s"},
            {"a_W", &FootReference::a_W, "m/s^2"}};
  }
};

/// References of all feet; stance feet rest at their touchdown position.
struct FeetReference {
  std::array<FootReference, kNumLegs> feet;

  FootReference& operator[](int leg) { return feet[leg]; }
  const FootReference& operator[](int leg) const { return feet[leg]; }
  static FieldList Fields() { return {{"feet", &FeetReference::feet, "", kLegElements}}; }
};

/// Planned path over ground: the present pose in the plane and the twist, constant in the frame of the
/// heading.
struct PlanarPath {
  Vec<2> position_W = Vec<2>::Zero();  ///< [m]
  double yaw = 0;                      ///< [rad]
  Vec<2> velocity = Vec<2>::Zero();    ///< forward and left [m/s]
  double yaw_rate = 0;                 ///< [rad/s]

  /// The path at `t` seconds from now, which may be negative: a line or an arc, in closed form.
  PlanarPath At(double t) const;
  Eigen::Matrix2d Heading() const;  ///< rotation from the frame of the heading to W
  Eigen::Vector2d VelocityW() const { return Heading() * velocity; }
  static FieldList Fields() {
    return {{"position_W", &PlanarPath::position_W, "m"},
            {"yaw", &PlanarPath::yaw, "rad"},
            {"velocity", &PlanarPath::velocity, "m/s"},
            {"yaw_rate", &PlanarPath::yaw_rate, "rad/s"}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::BodyReference);
TENON_DECLARE_SIGNAL(tenon::FeetReference);
TENON_DECLARE_SIGNAL(tenon::PlanarPath);
