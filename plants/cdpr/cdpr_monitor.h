#pragma once

#include <tenon/plants/cdpr/cdpr_geometry.h>
#include <tenon/plants/model/path.h>
#include <tenon/systems/block.h>

namespace tenon {

struct CdprMonitorParams {
  CdprDescription robot;
  bool forbid_slack = true;        ///< a slack cable ends the run
  double max_tension_ratio = 1.1;  ///< largest tension over the winches' tension_max
  Rate rate = Hz(1000);
};

/// Ends the run of a cable robot if
///  - a cable is slack, unless `forbid_slack` is false;
///  - a tension exceeds max_tension_ratio tension_max;
///  - the PlatformBox reaches below the floor, unless it slides on a table;
///  - the distance of the CoM from the centre of the anchors exceeds twice that of the farthest anchor.
///
/// The reason names the cable and the excess.
class CdprMonitor final : public LeafSystem<CdprMonitorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<CableSignals> cables{this, {"cables"}};
  InputPort<PlatformState> platform{this, {"platform"}};
  Parameter<bool> forbid_slack{
      this, {"forbid_slack"}, params.forbid_slack, "whether a slack cable ends the run"};
  Parameter<double> max_tension_ratio{this,
                                      {"max_tension_ratio"},
                                      params.max_tension_ratio,
                                      "maximum tension over the winches' tension_max",
                                      Range().AtLeast(1).Because("commands go up to tension_max")};
  Parameter<double> floor{
      this, {"floor", "m"}, params.robot.floor, "minimum height of the platform's box", Range().Finite()};
  Monitor tension{this, "tension", Sampled{params.rate}, Uses(cables, forbid_slack, max_tension_ratio),
                  &CdprMonitor::CheckTension};
  Monitor place{this, "place", Sampled{params.rate}, Uses(time, platform, floor), &CdprMonitor::CheckPlace};

 private:
  Verdict CheckTension(const CableSignals& cables, bool forbid_slack, double max_tension_ratio) const;
  Verdict CheckPlace(double time, const PlatformState& platform, double floor) const;

  Eigen::Vector3d half_{PlatformBox(params.robot)};
  MovingAnchors anchors_{params.robot};
};

}  // namespace tenon
