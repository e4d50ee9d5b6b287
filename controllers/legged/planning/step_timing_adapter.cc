#include <tenon/controllers/legged/planning/step_timing_adapter.h>

#include <Eigen/Geometry>

namespace tenon {

double StepTimingAdapter::CalcNext(const LeggedState& state, const BodyReference& body,
                                   const StepTiming& timing) const {
  if (timing.clock_rate == 1) return 1;
  const Eigen::Vector3d z = RotationFromQuaternion(body.q_WB).col(2), w = state.w_W - body.w_W;
  const Eigen::Vector3d tilt = z.cross(state.R_WB().col(2));
  const double predicted = (tilt + timing.lookahead * (w - w.dot(z) * z)).norm();
  return predicted > timing.free_tilt ? timing.clock_rate : 1;
}

}  // namespace tenon
