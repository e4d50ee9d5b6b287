#include <tenon/controllers/cdpr/cable_pd.h>
#include <tenon/controllers/cdpr/cdpr_kinematics.h>

namespace tenon {

void CablePd::CalcCommand(const CableSignals& cables, const CdprReference& reference, double stiffness,
                          double damping, CableVector* command) const {
  for (const Eigen::Index num : {cables.length.size(), reference.length.size()})
    CheckNumCables(params.robot.num_cables(), num, "CablePd");
  const auto tension = reference.tension + stiffness * (cables.length - reference.length) +
                       damping * (cables.length_rate - reference.length_rate);
  *command = tension.cwiseMax(params.robot.cable.tension_min).cwiseMin(params.robot.cable.tension_max);
}

}  // namespace tenon
