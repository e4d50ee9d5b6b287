#include <tenon/apps/common/report_scenario.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/format.h>

namespace tenon::apps {

void ReportScenario::Validate() const {
  static constexpr std::size_t kMost = 1000;  // larger pages are unreadable and too slow
  const auto demand = [](std::size_t count, const std::string& what) {
    if (count > kMost)
      throw ParameterError(
          fmt::format("{} has {} entries, but at most {} are allowed: remove some", what, count, kMost));
  };
  demand(plots.size(), "plots");
  demand(events.size(), "events");
  demand(bands.size(), "bands");
  for (std::size_t i = 0; i < plots.size(); ++i) {
    demand(plots[i].signals.size(), fmt::format("plots.{}.signals", i));
    demand(plots[i].references.size(), fmt::format("plots.{}.references", i));
  }
}

std::vector<Plot> PlotsOf(const ReportScenario& scenario, const std::vector<Plot>& others) {
  std::vector<Plot> plots = scenario.plots;
  plots.insert(plots.end(), others.begin(), others.end());
  return plots;
}

}  // namespace tenon::apps
