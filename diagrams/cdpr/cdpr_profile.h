#pragma once

#include <tenon/controllers/cdpr/cdpr_mpc_solver.h>
#include <tenon/plants/model/quadruped_description.h>

namespace tenon {

struct YamlFile;

/// Scale of a cable robot with its platform level at a point. `length` is the mean distance l from
/// attachments to anchors, `arm` the root mean square distance a of the attachments from the CoM.
using CdprScale = Scale;

CdprScale ScaleOf(const CdprDescription& robot, const Eigen::Vector3d& p_WB, double gravity = kGravity);

/// Gains of a CdprMpc.
struct CdprMpcGains {
  double horizon = 1;  ///< [s]
  int num_steps = 25;  ///< of the horizon
  CdprMpcWeights weights;

  static FieldList Fields() {
    return {Required("horizon_s", &CdprMpcGains::horizon)
                .Positive()
                .Scaled("horizon_t", [](double value, const Scale& scale) { return value * scale.Time(); }),
            Required("num_steps", &CdprMpcGains::num_steps).Between(1, 1000),
            Required("weights", &CdprMpcGains::weights)};
  }
};

/// Gains of a CablePd.
struct CablePdGains {
  DiagonalGains stiffness = 0;  ///< [N/m]
  DiagonalGains damping = 0;    ///< [N s/m]

  static FieldList Fields() {
    const auto masses = [](double gain, const Scale& scale) { return gain * scale.mass; };
    return {
        Required("stiffness_N_per_m", &CablePdGains::stiffness)
            .Positive()
            .Scaled("stiffness_m_per_s2", masses),
        Required("damping_N_s_per_m", &CablePdGains::damping).AtLeast(0).Scaled("damping_m_per_s", masses)};
  }
};

/// Gains of the controllers of one cable robot. Files such as diagrams/profiles/cable_robot.yaml give them
/// for robots of all sizes in the units of CdprScale. With x in units of l, rates in units of 1 / t and
/// tensions in units of m g, dynamically similar robots have equal gains; errors of attitude count as the
/// displacements of the attachments that they cause, a in place of l. The weights of the MPC in SI units are
///
///     position w / l^2,   velocity w t^2 / l^2,   attitude w a^2 / l^2,
///     angular velocity w a^2 t^2 / l^2,           tension w / (m g)^2.
struct CdprProfile {
  CdprMpcGains mpc;
  CablePdGains pd;

  static FieldList Fields() { return {Required("mpc", &CdprProfile::mpc), Required("pd", &CdprProfile::pd)}; }
};

/// Reads a shipped profile or a YAML file for a robot of this scale. Throws ParameterError.
CdprProfile LoadCdprProfile(const YamlFile& file, const CdprScale& scale);

}  // namespace tenon
