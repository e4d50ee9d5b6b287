#pragma once

#include <tenon/controllers/cdpr/cdpr_mpc_solver.h>
#include <tenon/plants/model/robot_scale.h>

#include <Eigen/Core>

namespace tenon {

struct YamlFile;

/// Scale of a cable robot with its platform level at a point.
struct CdprScale : RobotScale {  ///< `length` is the mean distance l from attachments to anchors
  double arm = 1;                ///< root mean square distance a of the attachments from the CoM [m]
};

CdprScale ScaleOf(const CdprDescription& robot, const Eigen::Vector3d& p_WB, double gravity = kGravity);

/// Gains of the controllers of one cable robot. Files such as diagrams/profiles/cable_robot.yaml give them
/// for robots of all sizes in the units of CdprScale. With x in units of l, rates in units of 1 / t and
/// tensions in units of m g, dynamically similar robots have equal gains; errors of attitude count as the
/// displacements of the attachments that they cause, a in place of l. The weights of the MPC in SI units are
///
///     position w / l^2,   velocity w t^2 / l^2,   attitude w a^2 / l^2,
///     angular velocity w a^2 t^2 / l^2,           tension w / (m g)^2.
struct CdprProfile {
  double horizon = 1;  ///< of the MPC [s]
  int num_steps = 25;  ///< of the horizon
  CdprMpcWeights weights;
  double pd_stiffness_N_per_m = 0;
  double pd_damping_N_s_per_m = 0;
};

/// Reads a shipped profile or a YAML file for a robot of this scale. Throws ParameterError.
CdprProfile LoadCdprProfile(const YamlFile& file, const CdprScale& scale);

}  // namespace tenon
