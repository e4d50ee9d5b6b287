#include <tenon/apps/common/ranges.h>
#include <tenon/systems/framework/block/rate.h>

namespace tenon::apps {

static constexpr double kFastest = 1e5;  // Hz

Range Rates() {
  return Range().Above(0).AtMost(kFastest).Also([](double hz) { Hz(hz); });
}

Range SamplePeriods() {
  return Range().AtLeast(1 / kFastest).Also([](double s) { Seconds(s); });
}

Range Places() {
  return Range().Between(-1000, 1000);
}

}  // namespace tenon::apps
