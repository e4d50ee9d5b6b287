#pragma once

#include <tenon/plants/model/cdpr_signals.h>
#include <tenon/systems/framework/parameter.h>
#include <tenon/systems/framework/ports.h>
#include <tenon/systems/framework/state.h>
#include <tenon/systems/framework/system.h>

namespace tenon {

struct SlackMonitorParams {
  bool forbid_slack = true;  ///< if not, the block does nothing
  Rate rate = Hz(1000);
};

/// Ends the run when a cable of a cable robot goes slack, for then it cannot pull where it should.
///
///     port in    cables
///     parameter  forbid_slack
class SlackMonitor final : public LeafSystem<SlackMonitorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<CableSignals> cables{this, {"cables"}};
  Parameter<bool> forbid_slack{this, {"forbid_slack"}, params.forbid_slack, "if not, the block does nothing"};
  Monitor slack{this, "slack", Sampled{params.rate}, Uses(cables, forbid_slack), &SlackMonitor::Check};

 private:
  Verdict Check(const CableSignals& cables, bool forbid_slack) const;
};

}  // namespace tenon
