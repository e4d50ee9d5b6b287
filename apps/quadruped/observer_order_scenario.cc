#include <tenon/apps/quadruped/observer_order_scenario.h>

#include <fmt/core.h>

namespace tenon::apps {

void VariantScenario::Validate() const {
  Demand(gains_per_s.empty() || !butterworth,
         fmt::format("the variant '{}' has gains_per_s and butterworth: leave one away", name));
}

void VariantScenario::Resolve() {
  gains_per_s = LegObserverGains{.gains = gains_per_s, .butterworth = butterworth}.Gains();
  butterworth.reset();
}

void ObserverOrderScenario::Validate() const {
  Demand(start_s >= 0 && duration_s > start_s,
         fmt::format("the force starts at {} s but the run ends at {} s: nothing would be seen", start_s,
                     duration_s));
  Demand(force_N.norm() > 0, "force_N is zero: there is nothing to estimate");
  Demand(!variants.empty(), "there are no variants: give gains to compare");
}

}  // namespace tenon::apps
