#include <tenon/plants/cdpr/slack_monitor.h>

#include <fmt/core.h>

namespace tenon {

Verdict SlackMonitor::Check(const CableSignals& cables, bool forbid_slack) const {
  if (!forbid_slack) return {};
  for (Eigen::Index i = 0; i < cables.tension.size(); ++i) {
    if (cables.tension[i] <= 0) return fmt::format("cable {} is slack", i);
  }
  return {};
}

}  // namespace tenon
