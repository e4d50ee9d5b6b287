#pragma once

#include <tenon/controllers/cdpr/cable_pd.h>
#include <tenon/controllers/cdpr/reference_balancer.h>
#include <tenon/controllers/cdpr/reference_generator.h>
#include <tenon/diagrams/cdpr/cdpr_observer.h>

namespace tenon {

/// The controller of a cable robot: an MPC, which knows the path, or a PD of the cable lengths.
///
///     estimate, load, broken cables ──► mpc ──► command
///
///     reference, load, broken cables ──► balancer ──► pd ──► command
///                               measured cables ──────▲
///
/// Without feedforward there is no balancer and the PD follows the reference itself. The constructor adds the
/// blocks to `loop` itself, so that their names are those of the loop.
struct CdprControl {
  CdprControl(Subdiagram& loop, const CdprLoopParams& params, const ReferenceGenerator& reference,
              const CdprWorld& world, const CdprObserver& observer);

  CdprMpc* mpc = nullptr;                       ///< null if the controller is a PD
  const OutputPort<double>* mpc_age = nullptr;  ///< age of its plan [s]; null if plans are there at once
  CablePd* pd = nullptr;                        ///< null if the controller is an MPC
  ReferenceBalancer* balancer = nullptr;        ///< balancer for a PD with feedforward

  const OutputPort<CableVector>& command() const { return mpc != nullptr ? mpc->command : pd->command; }
};

}  // namespace tenon
