#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/systems/geometry.h>

namespace tenon {

/// Joints of attached bodies.
enum class AttachedJoint {
  kWeld,    ///< no motion
  kPin,     ///< rotation about `axis`
  kSlider,  ///< translation along `axis`
  kBall,    ///< any rotation
};

/// A rigid body on a joint: a swinging load, a backpack on springs, a link of a tail or an arm. See Attach in
/// plants/attached_bodies.h.
///
/// The body's frame is at the joint, with axes parallel to those of the body that carries it if the joint's
/// coordinate is 0. A spring and a damper act on the joint's coordinate q, an angle [rad] or a displacement
/// [m]:
///
///     f = k (r - q) - d q',   r = rest + amplitude (sin(frequency t + phase) - sin(phase)),   |f| <= limit.
///
/// With an amplitude, this is a drive under joint PD control. The plant's inputs added_position_references
/// and added_speed_references replace r, and add d times the reference's speed to f. On a ball joint, q is
/// the rotation vector, r is 0, and the angular velocity takes the place of q'.
struct AttachedBody {
  std::string name;  ///< name of joint and body
  std::string on;    ///< trunk or platform (default), a joint of a leg, or an earlier body
  AttachedJoint joint = AttachedJoint::kPin;           ///< weld, pin, slider or ball
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< joint in the frame of the carrying body [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();     ///< axis of a pin or slider, of any length
  double mass = 0;                                     ///< mass of the body [kg]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< centre of mass, from the joint [m]
  Eigen::Vector3d edges = Eigen::Vector3d::Zero();     ///< edges of a box; 0: a ball [m]
  double radius = 0;                                   ///< radius of a ball; 0: a box [m]
  double stiffness = 0;                                ///< stiffness k in N m/rad, or N/m on a slider
  double damping = 0;                                  ///< damping d in N m s/rad, or N s/m on a slider
  double rest = 0;                                     ///< initial coordinate, and r at t = 0, in rad or m
  double amplitude = 0;  ///< amplitude of the spring's rest coordinate, in rad or m
  double frequency = 0;  ///< frequency of the spring's rest coordinate [rad/s]
  double phase = 0;      ///< phase of the spring's rest coordinate at t = 0; -pi/2: it begins at rest [rad]

  // Without keys in YAML, for links of a URDF.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();       ///< about the CoM; 0: uniform box or ball [kg m^2]
  double limit = std::numeric_limits<double>::infinity();  ///< largest |f|, in N m or N
  std::shared_ptr<const TriangleMesh> mesh;                ///< appearance; null: box or ball

  static FieldList Fields() {
    return {Required("name", &AttachedBody::name),
            {"on", &AttachedBody::on},
            {"joint", &AttachedBody::joint},
            {"position_m", &AttachedBody::position},
            {"axis", &AttachedBody::axis},
            Required("mass_kg", &AttachedBody::mass).Positive(),
            {"centre_m", &AttachedBody::centre},
            Field("edges_m", &AttachedBody::edges).Between(0, 100),
            Field("radius_m", &AttachedBody::radius).Between(0, 100),
            Field("stiffness", &AttachedBody::stiffness).AtLeast(0),
            Field("damping", &AttachedBody::damping).AtLeast(0),
            {"rest", &AttachedBody::rest},
            {"amplitude", &AttachedBody::amplitude},
            Field("frequency_rad_per_s", &AttachedBody::frequency).AtLeast(0),
            {"phase_rad", &AttachedBody::phase},
            Undescribed(&AttachedBody::inertia),
            Undescribed(&AttachedBody::limit),
            Undescribed(&AttachedBody::mesh)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Links of an arm that takes the place of a rigid part of the trunk.
struct MovingParts {
  std::vector<AttachedBody> bodies;
  RigidInertia at_rest;  ///< all of them at their rest coordinates, in the trunk's frame B
};

}  // namespace tenon
