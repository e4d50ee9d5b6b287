#include <tenon/apps/studies/observer_order_scenario.h>

#include <fmt/core.h>

namespace tenon::apps {

void VariantScenario::Validate() const {
  Demand(gains_per_s.empty() || !butterworth,
         fmt::format("the variant '{}' has both gains_per_s and butterworth: remove one of them", name));
}

void VariantScenario::Resolve() {
  gains_per_s = LegObserverGains{.gains = gains_per_s, .butterworth = butterworth}.Gains();
  butterworth.reset();
}

void ObserverOrderScenario::Validate() const {
  Demand(start_s >= 0 && duration_s > start_s,
         fmt::format("start_s = {} is not within the run, which ends at {} s: start the force earlier",
                     start_s, duration_s));
  Demand(force_N.norm() > 0, "force_N must not be zero: its estimate is studied");
  Demand(!variants.empty(), "variants must not be empty: give gains to compare");
}

}  // namespace tenon::apps
