#include <tenon/apps/common/link_scenario.h>
#include <tenon/systems/framework/block/system.h>

#include <fmt/core.h>

namespace tenon::apps {

void LinkScenario::Validate() const {
  Demand(jitter_s <= delay_s,
         fmt::format("jitter_s = {} must be at most delay_s = {}: delays cannot be negative", jitter_s,
                     delay_s));
}

}  // namespace tenon::apps
