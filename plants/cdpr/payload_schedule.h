#pragma once

#include <tenon/plants/model/cdpr_signals.h>
#include <tenon/systems/framework/ports.h>
#include <tenon/systems/framework/system.h>

namespace tenon {

struct PayloadScheduleParams {
  Payload payload;        ///< none by default
  double attach_s = 0;    ///< [s]
  double release_s = 0;   ///< [s]
  Rate rate = Hz(100);    ///< the instants are rounded up to its ticks
  void Validate() const;  ///< throws ParameterError
};

/// Hangs a payload on a platform at one time and lets it go at another:
///
///     payload(t) = the payload if attach <= t < release, else none
///
///     port out  payload  sampled
class PayloadSchedule final : public LeafSystem<PayloadScheduleParams> {
 public:
  using LeafSystem::LeafSystem;
  OutputPort<Payload> payload{
      this, {"payload"}, Sampled{params.rate}, Uses(time), &PayloadSchedule::CalcPayload};

 private:
  Payload CalcPayload(const double& time) const;
};

}  // namespace tenon
