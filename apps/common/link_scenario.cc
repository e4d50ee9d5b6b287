#include <tenon/apps/common/checks.h>
#include <tenon/apps/common/link_scenario.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

namespace tenon::apps {

void LinkScenario::Validate() const {
  DemandBetween("delay_s", delay_s, 0, 1);
  Demand(jitter_s >= 0 && jitter_s <= delay_s,
         fmt::format("jitter_s = {} must be from 0 to delay_s = {}: delays cannot be negative", jitter_s,
                     delay_s));
}

}  // namespace tenon::apps
