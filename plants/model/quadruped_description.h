#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/signals/leg.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/signal.h>
#include <tenon/systems/geometry.h>

#include <Eigen/Core>

#include <array>
#include <memory>
#include <string>

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

/// Abduction (about x), hip pitch (about y), knee pitch (about y), and the bodies that they move.
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

/// Motor, gear and end stops of a joint; the same for all.
struct DriveProperties {
  double rotor_inertia = 0;            ///< seen at the joint, times gear ratio squared [kg m^2]
  double damping = 0;                  ///< [N m s/rad]
  double friction = 0;                 ///< Coulomb's [N m]
  double full_torque_speed_ratio = 0;  ///< full torque up to this part of the speed limit, see QuadrupedPlant
  double stop_stiffness = 0;           ///< of the end stops [N m/rad]
  double stop_dissipation = 0;         ///< see QuadrupedPlant [s/rad]

  static FieldList Fields() {
    return {Required("rotor_inertia_kg_m2", &DriveProperties::rotor_inertia),
            Required("damping_N_m_s_per_rad", &DriveProperties::damping),
            Required("friction_N_m", &DriveProperties::friction),
            Required("full_torque_speed_ratio", &DriveProperties::full_torque_speed_ratio),
            Required("stop_stiffness_N_m_per_rad", &DriveProperties::stop_stiffness),
            Required("stop_dissipation_s_per_rad", &DriveProperties::stop_dissipation)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A foot against the ground; what the numbers do is told in foot_contact.h.
struct ContactProperties {
  double stiffness = 0;           ///< k [N/m]
  double dissipation = 0;         ///< c [s/m]
  double blend = 0;               ///< depth over which the normal force sets in [m]
  double bristle_stiffness = 0;   ///< sigma_0 [1/m]
  double bristle_damping = 0;     ///< sigma_1 [s/m]
  double bristle_friction = 0.2;  ///< mu_0, the least coefficient that has a bristle of its own
  double full_friction = 0;       ///< N_0 [N]
  double release_time = 0;        ///< tau [s]

  static FieldList Fields() {
    return {Required("stiffness_N_per_m", &ContactProperties::stiffness),
            Required("dissipation_s_per_m", &ContactProperties::dissipation),
            Required("blend_m", &ContactProperties::blend),
            Required("bristle_stiffness_per_m", &ContactProperties::bristle_stiffness),
            Required("bristle_damping_s_per_m", &ContactProperties::bristle_damping),
            {"bristle_friction", &ContactProperties::bristle_friction},
            Required("full_friction_N", &ContactProperties::full_friction),
            Required("release_time_s", &ContactProperties::release_time)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A quadruped: a trunk and four legs of three revolute joints. x forward, y left, z up.
///
/// Links that fixed joints connect are one body here; a massless root link is the trunk's frame B.
struct QuadrupedDescription {
  std::string name;
  RigidInertia trunk;  ///< in B
  std::array<LegDescription, kNumLegs> legs;
  double foot_radius = 0;                           ///< [m]
  Eigen::Vector3d imu_B = Eigen::Vector3d::Zero();  ///< where the inertial unit is, its axes along B's [m]
  Vec<kNumJoints> stance = Vec<12>::Zero();         ///< joint angles at which it stands [rad]
  DriveProperties drive;
  ContactProperties contact;
  /// How trunk and links look, each in its body's frame; none where the URDF has no mesh that can be read.
  std::array<std::shared_ptr<const TriangleMesh>, 1 + kNumJoints> meshes;

  double mass() const;
  const JointDescription& joint(int j) const {
    return legs[static_cast<std::size_t>(j / kJointsPerLeg)]
        .joints[static_cast<std::size_t>(j % kJointsPerLeg)];
  }
  /// The second joint of the leg, from which it is stretched, in B at the joint angles q [m].
  Eigen::Vector3d HipPosition(int leg, const Vec<kNumJoints>& q) const;
  /// From there to the centre of the foot's sphere when the leg is straight [m].
  double LegLength(int leg) const;
  /// Centre of the foot's sphere in B at the joint angles q [m].
  Eigen::Vector3d FootPosition(int leg, const Vec<kNumJoints>& q) const;
  /// Pose of the leg's three bodies at the joint angles q [rad].
  LegPose PoseOfLeg(int leg, const Vec<kNumJoints>& q) const;
  /// Height of B's origin over level ground that the feet touch in the stance: the mean over the feet [m].
  double StanceHeight() const;
};

/// The robot with a rigid body fixed to its trunk, given in B; exact. Controllers may keep the robot without.
/// Throws ParameterError unless the payload's mass is 0 or more.
QuadrupedDescription WithPayload(QuadrupedDescription robot, const RigidInertia& payload);

/// The robot with masses and inertias times a factor: what a controller believes that does not know better.
/// Throws ParameterError unless the factor is positive.
QuadrupedDescription WithMassFactor(QuadrupedDescription robot, double factor);

}  // namespace tenon
