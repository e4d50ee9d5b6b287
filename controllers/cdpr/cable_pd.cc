#include <tenon/controllers/cdpr/cable_pd.h>
#include <tenon/controllers/cdpr/cdpr_kinematics.h>

#include <fmt/core.h>

#include <cmath>

namespace tenon {

void CablePdParams::Validate() const {
  Demand(std::isfinite(stiffness_N_per_m) && stiffness_N_per_m > 0,
         fmt::format(
             "stiffness_N_per_m = {} must be finite and positive: otherwise length errors are not corrected",
             stiffness_N_per_m));
  Demand(std::isfinite(damping_N_s_per_m) && damping_N_s_per_m >= 0,
         fmt::format(
             "damping_N_s_per_m = {} must be finite and not negative: otherwise it amplifies oscillations",
             damping_N_s_per_m));
}

void CablePd::CalcCommand(const CableSignals& cables, const CdprReference& reference, double stiffness,
                          double damping, CableVector* command) const {
  for (const Eigen::Index num : {cables.length.size(), reference.length.size()})
    CheckNumCables(params.robot.num_cables(), num, "CablePd");
  const auto tension = reference.tension + stiffness * (cables.length - reference.length) +
                       damping * (cables.length_rate - reference.length_rate);
  *command = tension.cwiseMax(params.robot.cable.tension_min).cwiseMin(params.robot.cable.tension_max);
}

}  // namespace tenon
