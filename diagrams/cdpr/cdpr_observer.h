#pragma once

#include <tenon/controllers/cdpr/broken_cable_detector.h>
#include <tenon/diagrams/cdpr/cdpr_world.h>

namespace tenon {

/// The estimates that the controller of a cable robot uses, from the measurements of its world. Those that
/// the controller does not need are null.
///
///     pose, inertial, cables ──► estimator ──► load
///                     cables ──► broken_cables
///
/// With `known_additions`, `load` measures the plant's `added_wrench` without errors and estimates the rest.
/// Without a load estimator, `controller_load` is this wrench alone, at the controller's rate.
///
/// The constructor adds the blocks to `loop` itself, so that their names are those of the loop. The command
/// that `broken_cables` compares the tensions with remains to be connected.
struct CdprObserver {
  CdprObserver(Subdiagram& loop, const CdprLoopParams& params, const CdprWorld& world);

  CdprEstimator* estimator = nullptr;            ///< estimator for the MPC and the load estimator
  LoadEstimator* load = nullptr;                 ///< load estimator for offset-free control
  BrokenCableDetector* broken_cables = nullptr;  ///< detector for all but a PD without feedforward
  const OutputPort<LoadEstimate>* controller_load = nullptr;  ///< load that the controller uses, or null
};

/// The load estimator of an MPC has the defaults of LoadEstimatorParams. The one of a PD has bandwidths of
/// 3 rad/s: from 5 rad/s on, cables go slack when the load of D2 is released.
LoadEstimatorParams MakeLoadEstimator(bool mpc);

}  // namespace tenon
