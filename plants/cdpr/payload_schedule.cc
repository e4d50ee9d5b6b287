#include <tenon/plants/cdpr/payload_schedule.h>

#include <fmt/core.h>

namespace tenon {

void PayloadScheduleParams::Validate() const {
  Demand(release_s >= attach_s,
         fmt::format("release_s = {} must not be before attach_s = {}", release_s, attach_s));
}

Payload PayloadSchedule::CalcPayload(double time, const Payload& load, double attach, double release) const {
  return time >= attach && time < release ? load : Payload{};
}

}  // namespace tenon
