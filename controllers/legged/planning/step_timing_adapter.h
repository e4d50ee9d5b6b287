#pragma once

#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Limits of a StepTimingAdapter.
struct StepTiming {
  double lookahead = 0.1;  ///< time for which the rate of the tilt is extrapolated [s]
  double free_tilt = 0.3;  ///< predicted tilt of the trunk above which swing feet land early [rad]
  double clock_rate = 2;   ///< speed of the gait clock then; 1 never adapts it

  static FieldList Fields() {
    return {Field("lookahead_s", &StepTiming::lookahead)
                .AtLeast(0)
                .Scaled("lookahead_t", [](double time, const Scale& s) { return time * s.Time(); }),
            Field("free_tilt_rad", &StepTiming::free_tilt).Positive().OrInfinite(),
            Field("clock_rate", &StepTiming::clock_rate).AtLeast(1).AtMost(4)};
  }
};

struct StepTimingAdapterParams {
  StepTiming timing;
  Rate rate = Hz(1000);
};

/// Lets swing feet land early while the trunk falls (after Khadiv et al., Step timing adjustment, Humanoids
/// 2016).
///
/// Two feet exert no moment about the line between them, so a push that they resist rolls the trunk about it
/// until a swing foot lands. With the angle e from the z axis of the reference to that of the trunk, and the
/// angular velocity w across the reference's z axis, relative to that of the reference, the predicted tilt is
///
///     |e + T w|,    |e| = sin(tilt),
///
/// for the lookahead T. While it exceeds free_tilt, the gait clock runs at clock_rate during swings, else
/// at 1. The phase of the swing is continuous, the foot lands at its foothold, and the next step is as
/// planned again.
///
/// The output belongs to the inputs of the tick before: the state may depend on the schedule.
class StepTimingAdapter final : public LeafSystem<StepTimingAdapterParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<BodyReference> body{this, {"body"}};
  Parameter<StepTiming> timing{this, {"timing"}, params.timing, "limits of the early landing of swing feet"};
  DiscreteState<double> next{this, {"next"}, 1};
  OutputPort<double> clock_rate{
      this, {"clock_rate"}, 1, Sampled{params.rate}, Uses(next), [](double rate) { return rate; }};
  Update<double> update{next, Sampled{params.rate}, Uses(state, body, timing), &StepTimingAdapter::CalcNext};

 private:
  double CalcNext(const LeggedState& state, const BodyReference& body, const StepTiming& timing) const;
};

}  // namespace tenon
