#include <tenon/controllers/cdpr/cable_pd.h>

namespace tenon {

void CablePd::CalcCommand(const CableSignals& cables, const CdprReference& reference, double stiffness,
                          double damping, CableVector* command) const {
  for (const Eigen::Index num : {cables.length.size(), reference.length.size()})
    CheckNumCables(params.robot.num_cables(), num, "CablePd");
  *command = reference.tension + stiffness * (cables.length - reference.length) +
             damping * (cables.length_rate - reference.length_rate);
  params.robot.LimitTension(command);
}

}  // namespace tenon
