#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/signals/leg.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/geometry.h>

namespace tenon {

/// A revolute joint between a body P and the next one, J, in a leg. The axes of all bodies are parallel to
/// the trunk's when all joint angles are 0, so R_PJ(q) = exp(q axis x).
struct JointDescription {
  std::string name;
  Eigen::Vector3d p_PJ = Eigen::Vector3d::Zero();   ///< origin of J, which lies on the axis, in P [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< in P and in J
  double lower = 0, upper = 0;                      ///< range [rad]; infinite if continuous
  double torque_limit = 0;                          ///< [N m]
  double speed_limit = 0;                           ///< [rad/s]
};

/// A leg: the joints abduction (about x), hip pitch (about y) and knee pitch (about y), and the bodies they
/// move.
struct LegDescription {
  std::array<JointDescription, kJointsPerLeg> joints;
  std::array<RigidInertia, kJointsPerLeg> bodies;    ///< in the joint's frame J
  Eigen::Vector3d foot_J = Eigen::Vector3d::Zero();  ///< centre of the foot's sphere in the last J [m]
};

/// Pose of a leg in the trunk's frame B.
struct LegPose {
  std::array<Eigen::Matrix3d, kJointsPerLeg> R_BJ;  ///< axes of the bodies
  std::array<Eigen::Vector3d, kJointsPerLeg> p_BJ;  ///< origins of the joints [m]
  Eigen::Vector3d foot_B;                           ///< centre of the foot's sphere [m]
};

/// A collision shape: a box whose surface is moved outwards by a radius. Spheres and capsules are such boxes.
struct RoundedBox {
  Eigen::Vector3d p_B = Eigen::Vector3d::Zero();       ///< its centre [m]
  Eigen::Matrix3d R_BS = Eigen::Matrix3d::Identity();  ///< its axes
  Eigen::Vector3d half = Eigen::Vector3d::Zero();      ///< half edges of the box [m]
  double radius = 0;                                   ///< [m]
};

/// Motor, gear and end stops, equal for all joints.
struct DriveProperties {
  double rotor_inertia = 0;            ///< at the joint, i.e. times gear ratio squared [kg m^2]
  double damping = 0;                  ///< viscous friction [N m s/rad]
  double friction = 0;                 ///< Coulomb friction [N m]
  double full_torque_speed_ratio = 0;  ///< fraction of the speed limit with full torque, see QuadrupedPlant
  double stop_stiffness = 0;           ///< stiffness of the end stops [N m/rad]
  double stop_dissipation = 0;         ///< see QuadrupedPlant [s/rad]

  static FieldList Fields() {
    return {Required("rotor_inertia_kg_m2", &DriveProperties::rotor_inertia).AtLeast(0),
            Required("damping_N_m_s_per_rad", &DriveProperties::damping)
                .Between(0, 1e4)
                .Because("a joint with more does not move"),
            Required("friction_N_m", &DriveProperties::friction).AtLeast(0),
            Required("full_torque_speed_ratio", &DriveProperties::full_torque_speed_ratio)
                .AtLeast(0)
                .Below(1)
                .Because("the part of the speed limit up to which the motor has its full torque"),
            Required("stop_stiffness_N_m_per_rad", &DriveProperties::stop_stiffness).AtLeast(0),
            Required("stop_dissipation_s_per_rad", &DriveProperties::stop_dissipation).AtLeast(0)};
  }
};

/// Contact model of the feet, see foot_contact.h.
struct ContactProperties {
  double stiffness = 0;           ///< k [N/m]
  double dissipation = 0;         ///< c [s/m]
  double blend = 0;               ///< b, depth over which the stiffness rises [m]
  double bristle_stiffness = 0;   ///< sigma_0 [1/m]
  double bristle_damping = 0;     ///< sigma_1 [s/m]
  double bristle_friction = 0.2;  ///< mu_0, lower bound of the friction that sets the bristle's deflection
  double full_friction = 0;       ///< N_0 [N]
  double release_time = 0;        ///< tau [s]

  static FieldList Fields() {
    using P = ContactProperties;
    return {Required("stiffness_N_per_m", &P::stiffness)
                .Positive()
                .Because("the weight on a foot over its static depth"),
            Required("dissipation_s_per_m", &P::dissipation).AtLeast(0),
            Required("blend_m", &P::blend).Positive().Because("about a tenth of the static depth"),
            Required("bristle_stiffness_per_m", &P::bristle_stiffness)
                .Positive()
                .Because("the friction coefficient over the deflection before sliding"),
            Required("bristle_damping_s_per_m", &P::bristle_damping).AtLeast(0),
            Field("bristle_friction", &P::bristle_friction)
                .Positive()
                .Because("0.2, or the lowest friction of interest"),
            Required("full_friction_N", &P::full_friction)
                .Positive()
                .Because("a small fraction of the weight on a foot"),
            Required("release_time_s", &P::release_time).Positive().Because("a few milliseconds")};
  }
};

/// A quadruped: a trunk and four legs of three revolute joints. x forward, y left, z up.
///
/// Links connected by fixed joints are one body; a massless root link is the trunk's frame B.
struct QuadrupedDescription {
  std::string name;
  RigidInertia trunk;  ///< in B
  std::array<LegDescription, kNumLegs> legs;
  double foot_radius = 0;                           ///< [m]
  Eigen::Vector3d imu_B = Eigen::Vector3d::Zero();  ///< position of the IMU, whose axes are those of B [m]
  Vec<kNumJoints> stance = Vec<12>::Zero();         ///< joint angles of the nominal stance [rad]
  DriveProperties drive;
  ContactProperties contact;
  /// Collision shapes of the trunk in the URDF; empty if it has none that cover the trunk.
  std::vector<RoundedBox> trunk_shapes;
  /// Visual meshes of trunk and links, each in its body's frame; null if the URDF has no readable mesh.
  std::array<std::shared_ptr<const TriangleMesh>, 1 + kNumJoints> meshes;

  double mass() const;
  void CheckMass() const;  ///< throws ParameterError if the robot has no mass
  const JointDescription& joint(int j) const { return legs[j / kJointsPerLeg].joints[j % kJointsPerLeg]; }
  /// Origin of the leg's hip pitch joint in B at the joint angles q [m].
  Eigen::Vector3d HipPosition(int leg, const Vec<kNumJoints>& q) const;
  /// Distance from the hip pitch joint to the centre of the foot's sphere with a straight leg [m].
  double LegLength(int leg) const;
  /// The longest such distance that the range of the knee allows [m].
  double LongestExtension(int leg) const;
  /// Centre of the foot's sphere in B at the joint angles q [m].
  Eigen::Vector3d FootPosition(int leg, const Vec<kNumJoints>& q) const;
  /// Pose of the leg's three bodies at the joint angles q [rad].
  LegPose PoseOfLeg(int leg, const Vec<kNumJoints>& q) const;
  /// Height of B's origin above level ground in the nominal stance, as the mean over the feet [m].
  double StanceHeight() const;
};

/// The robot with a rigid body fixed to its trunk, given in B. Throws ParameterError unless the payload's
/// mass is at least 0.
QuadrupedDescription WithPayload(QuadrupedDescription robot, const RigidInertia& payload);

/// The robot with all masses and inertias multiplied by a factor, to model a wrong mass in a controller.
/// Throws ParameterError unless the factor is finite and positive.
QuadrupedDescription WithMassFactor(QuadrupedDescription robot, double factor);

/// The scale of a robot with legs. Its length is the mean length of the straight legs, from hip to foot.
using RobotScale = Scale;

RobotScale ScaleOf(const QuadrupedDescription& robot, double gravity = kGravity);

/// Bounds of random errors in a model of a robot. Each error is drawn for each of the 13 bodies
/// independently, from a uniform distribution symmetric about 0.
struct ModelErrorParams {
  double mass_ratio = 0;     ///< error of a body's mass, which scales its inertia
  double com_ratio = 0;      ///< error of a body's CoM along each axis, over the body's length
  double inertia_ratio = 0;  ///< error of a body's inertia about its CoM, in addition to the mass error
  double length_ratio = 0;   ///< error of the length of each link of a leg

  static FieldList Fields() {
    FieldList fields{{"mass_ratio", &ModelErrorParams::mass_ratio},
                     {"com_ratio", &ModelErrorParams::com_ratio},
                     {"inertia_ratio", &ModelErrorParams::inertia_ratio},
                     {"length_ratio", &ModelErrorParams::length_ratio}};
    for (Field& field : fields) field.AtLeast(0).Below(1).Because("0.1 is an error of up to 10 %");
    return fields;
  }
};

/// A robot with random errors in the masses, centres of mass and inertias of all bodies and in the lengths of
/// the legs' links, drawn from `random`. A body's length is the distance to the next joint or to the foot;
/// the trunk's is the distance between the centres of its front and rear hips. Joint axes, drives, feet and
/// stance angles are unchanged. Throws ParameterError.
QuadrupedDescription WithModelError(QuadrupedDescription robot, const ModelErrorParams& error,
                                    RandomStream& random);

}  // namespace tenon
