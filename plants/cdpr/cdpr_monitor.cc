#include <tenon/plants/cdpr/cdpr_monitor.h>
#include <tenon/plants/model/rigid_inertia.h>

#include <fmt/core.h>

namespace tenon {
Verdict CdprMonitor::CheckTension(const CableSignals& cables, bool forbid_slack,
                                  double max_tension_ratio) const {
  CheckNumCables(params.robot.num_cables(), cables.tension.size(), "CdprMonitor");
  for (Eigen::Index i = 0; i < cables.tension.size(); ++i) {
    // A cable whose tension is at most its weight is slack.
    const double weight = params.robot.cable.mass_per_length * kGravity * cables.rest_length[i];
    if (forbid_slack && cables.tension[i] <= weight) return fmt::format("cable {} is slack", i);
    const double limit = max_tension_ratio * params.robot.tension_max(i);
    if (cables.tension[i] > limit)
      return fmt::format("cable {} pulls with {:.0f} N; its winch holds {:.0f} N", i, cables.tension[i],
                         limit);
  }
  return {};
}

Verdict CdprMonitor::CheckPlace(double time, const PlatformState& platform, double floor) const {
  const double lowest = LowestCorner(half_, platform.p_WB, platform.R_WB());
  if (lowest < floor && !params.robot.on_table)
    return fmt::format("the platform reaches {:.3g} m below the floor at {:.3g} m (floor_m of the robot)",
                       floor - lowest, floor);

  const auto anchor_W = [&](int i) -> Eigen::Vector3d {
    return params.robot.cables[i].anchor_W + anchors_.At(i, time).position;
  };
  const int n = params.robot.num_cables();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (int i = 0; i < n; ++i) middle += anchor_W(i) / n;
  double reach = 0;
  for (int i = 0; i < n; ++i) reach = std::max(reach, (anchor_W(i) - middle).norm());
  const double distance = (platform.p_WB - middle).norm();
  if (distance <= 2 * reach) return {};
  return fmt::format("the platform is {:.4g} m away from the middle of the anchors; the limit is {:.4g} m",
                     distance, 2 * reach);
}

}  // namespace tenon
