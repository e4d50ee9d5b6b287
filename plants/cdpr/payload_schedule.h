#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// A point mass attached to the platform for part of the run. It is missing from the controller's model.
struct PayloadScheduleParams {
  Payload payload;       ///< none by default
  double attach_s = 0;   ///< time at which the payload is attached [s]
  double release_s = 0;  ///< time at which the payload is released [s]
  Rate rate = Hz(100);   ///< rate of the ticks to which both times are rounded up

  static FieldList Fields() {
    using P = PayloadScheduleParams;
    return {Field("mass_kg", &P::payload, &Payload::mass).AtLeast(0),
            Field("position_m", &P::payload, &Payload::p_B).Between(-1000, 1000),
            {"attach_s", &P::attach_s},
            {"release_s", &P::release_s},
            Undescribed(&P::rate)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Attaches a payload to a platform at one time and releases it at a later time:
///
///     payload(t) = the payload if attach <= t < release, else none
///
/// The payload and both times are Parameters: a run can change them.
class PayloadSchedule final : public LeafSystem<PayloadScheduleParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<Payload> load{this, {"load"}, params.payload, "load on the platform"};
  Parameter<double> attach{this, {"attach", "s"}, params.attach_s, "time at which the load is attached"};
  Parameter<double> release{this, {"release", "s"}, params.release_s, "time at which the load is released"};
  OutputPort<Payload> payload{this,
                              {"payload"},
                              Sampled{params.rate},
                              Uses(time, load, attach, release),
                              &PayloadSchedule::CalcPayload};

 private:
  Payload CalcPayload(double time, const Payload& load, double attach, double release) const {
    return time >= attach && time < release ? load : Payload{};
  }
};

}  // namespace tenon
