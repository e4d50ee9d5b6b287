#pragma once

#include <tenon/diagrams/cdpr/cdpr_control.h>

namespace tenon {

/// A cable robot under its length controller (Morlando 2023, section 3.5.2),
///
///     reference ──► control ──► world ──► measured cables ──┐
///                      ▲                                    │
///                      └────────────────────────────────────┘
///
/// or under its model predictive controller (section 3.4), which knows the path in advance:
///
///     control ──► world ──► measured pose, inertial unit, cables ──► observer ──┐
///        ▲                                                                      │
///        └──────────────── estimated state and load, broken cables ─────────────┘
///
/// With feedforward, the PD follows a reference that ReferenceBalancer makes consistent with the acceleration
/// of the path. With offset-free control, PD or MPC compensate the load that LoadEstimator finds, so that a
/// constant load leaves no error. All controllers except the PD without feedforward stop using cables that
/// BrokenCableDetector reports as broken.
///
/// All blocks are blocks of this diagram, with the names of the members of `world`, `observer` and `control`,
/// which are public for logs and for replacing parts.
class CdprLoop final : public Subdiagram {
 public:
  explicit CdprLoop(const CdprLoopParams& params);

  ReferenceGenerator& reference;
  CdprWorld world;
  CdprObserver observer;
  CdprControl control;

  OutputPort<CableVector> command{this, {"command", "N"}};  ///< command of the controller
  OutputPort<PlatformState> platform{this, {"platform"}};   ///< true state of the platform
  OutputPort<CableSignals> cables{this, {"cables"}};        ///< true lengths and tensions
  OutputPort<PoseMeasurement> pose{this, {"pose"}};         ///< measured pose, with its latency
  OutputPort<ImuMeasurement> inertial{this, {"inertial"}};  ///< measurement of the IMU, with its latency
};

}  // namespace tenon
