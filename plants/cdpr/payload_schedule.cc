#include <tenon/plants/cdpr/payload_schedule.h>

#include <fmt/core.h>

#include <cmath>

namespace tenon {

void PayloadScheduleParams::Validate() const {
  Demand(std::isfinite(payload.mass) && payload.mass >= 0,
         fmt::format("the payload's mass of {} kg must be finite and not negative", payload.mass));
  Demand(payload.p_B.allFinite(), "the payload's place p_B is not finite: give metres");
  Demand(release_s >= attach_s,
         fmt::format("the payload is released at {} s, before it is attached at {} s: exchange them",
                     release_s, attach_s));
}

Payload PayloadSchedule::CalcPayload(double time, const Payload& load, double attach, double release) const {
  return time >= attach && time < release ? load : Payload{};
}

}  // namespace tenon
