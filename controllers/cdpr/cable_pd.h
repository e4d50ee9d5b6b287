#pragma once

#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/framework/types/diagonal_gains.h>

namespace tenon {

struct CablePdParams {
  CdprDescription robot;                ///< model of the controller; its tension bounds limit the command
  DiagonalGains stiffness_N_per_m = 0;  ///< gain K_p of each cable's length error
  DiagonalGains damping_N_s_per_m = 0;  ///< gain K_d of the error of each length's rate
  Rate rate = Hz(1000);

  void Validate() const {  ///< throws ParameterError
    stiffness_N_per_m.CheckSize("stiffness", robot.num_cables(), "cables");
    damping_N_s_per_m.CheckSize("damping", robot.num_cables(), "cables");
  }
};

/// Length controller with a tension feedforward for each cable (Morlando 2023, eq. (3.25)):
///
///     f = f* + K_p (l - l_des) + K_d (l̇ - l̇_des),   limited to [tension_min, tension_max]
///
/// with the tensions f* of the static equilibrium at the reference. The thesis prints the opposite sign,
/// l_des - l, which would slacken a cable that is too long and is unstable.
class CablePd final : public LeafSystem<CablePdParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<CableSignals> cables{this, {"cables"}};
  InputPort<CdprReference> reference{this, {"reference"}};
  Parameter<DiagonalGains> stiffness{this,
                                     {"stiffness", "N/m"},
                                     params.stiffness_N_per_m,
                                     "tension per length error",
                                     Range().Positive().Because("otherwise length errors are not corrected")};
  Parameter<DiagonalGains> damping{this,
                                   {"damping", "N s/m"},
                                   params.damping_N_s_per_m,
                                   "tension per error of the length's rate",
                                   Range().AtLeast(0).Because("otherwise it amplifies oscillations")};
  OutputPort<CableVector> command{this,
                                  {"command", "N"},
                                  CableVector::Zero(params.robot.num_cables()),
                                  Sampled{params.rate},
                                  Uses(cables, reference, stiffness, damping),
                                  &CablePd::CalcCommand};

 private:
  void CalcCommand(const CableSignals& cables, const CdprReference& reference, const DiagonalGains& stiffness,
                   const DiagonalGains& damping, CableVector* command) const {
    for (const Eigen::Index num : {cables.length.size(), reference.length.size()})
      CheckNumCables(params.robot.num_cables(), num, "CablePd");
    *command = reference.tension + stiffness * (cables.length - reference.length) +
               damping * (cables.length_rate - reference.length_rate);
    params.robot.LimitTension(command);
  }
};

}  // namespace tenon
