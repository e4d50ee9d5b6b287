#include <tenon/plants/cdpr/payload_schedule.h>

#include <fmt/core.h>

namespace tenon {

void PayloadScheduleParams::Validate() const {
  Demand(payload.mass >= 0, fmt::format("the payload's mass of {} kg must not be negative", payload.mass));
  Demand(release_s >= attach_s,
         fmt::format("the payload is released at {} s, before it is attached at {} s: exchange them",
                     release_s, attach_s));
}

Payload PayloadSchedule::CalcPayload(double time, const Payload& load, double attach, double release) const {
  return time >= attach && time < release ? load : Payload{};
}

}  // namespace tenon
