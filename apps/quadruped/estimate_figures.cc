#include <tenon/apps/quadruped/estimate_figures.h>
#include <tenon/diagrams/evaluation/tracking_error.h>

#include <Eigen/Geometry>

namespace tenon::apps {

void StateErrors::Add(std::span<const double> row, const StateColumns& estimated, const StateColumns& truth) {
  const double velocity = (VectorIn<3>(row, estimated.velocity) - VectorIn<3>(row, truth.velocity)).norm();
  // The vertical in the axes of the trunk, true and estimated.
  const Vec<3> up = RotationFromQuaternion(VectorIn<4>(row, truth.attitude)).row(2);
  const Vec<3> estimated_up = RotationFromQuaternion(VectorIn<4>(row, estimated.attitude)).row(2);
  const double tilt = std::atan2(up.cross(estimated_up).norm(), up.dot(estimated_up));
  velocity_.Add(velocity);
  tilt_.Add(tilt);
  const Vec<3> distance = VectorIn<3>(row, estimated.position) - VectorIn<3>(row, truth.position);
  position_end_ = distance.norm();
  drift.Add(distance.norm());
  height_drift.Add(std::abs(distance[2]));
}

void StateErrors::AddTo(Summary& summary, const std::string& prefix) const {
  summary.Set(prefix + "velocity_estimate_error_rms_m_per_s", velocity_.rms());
  summary.Set(prefix + "velocity_estimate_error_max_m_per_s", velocity_.max());
  summary.Set(prefix + "tilt_estimate_error_rms_rad", tilt_.rms());
  summary.Set(prefix + "tilt_estimate_error_max_rad", tilt_.max());
  summary.Set(prefix + "position_estimate_error_end_m", position_end_);
}

void EstimateFigures::Begin(const std::vector<std::string>& names) {
  if (loop_.estimator == nullptr) return;
  const OutputPort<LeggedEstimate>* const estimate = FindCurrent(loop_.estimator->estimate);
  if (estimate == nullptr) return;
  true_ = StateColumns::Of(names, loop_.world.plant.state);
  estimated_ = StateColumns::Of(names, *estimate, &LeggedEstimate::state);
  path_com_ = Columns(names, FindCurrent(loop_.errors.path), &PathErrors::com);
  path_foot_ = Columns(names, FindCurrent(loop_.errors.path), &PathErrors::foot);
}

void EstimateFigures::Row(std::span<const double> row) {
  if (estimated_.velocity.empty()) return;
  errors_.Add(row, estimated_, true_);
  if (path_com_.empty()) return;
  path_errors_.Add(VectorIn<3>(row, path_com_).norm());
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)  // 0 marks a foot in stance
    if (row[path_foot_[leg]] > 0) path_foot_errors_[leg].Add(row[path_foot_[leg]]);
}

void EstimateFigures::AddTo(Summary& summary) const {
  if (estimated_.velocity.empty()) return;
  errors_.AddTo(summary);
}

bool EstimateFigures::AddPathTo(Summary& summary) const {
  if (estimated_.velocity.empty()) return false;
  std::vector<std::pair<std::string, std::optional<double>>> feet;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    feet.emplace_back(kLegNames[leg], path_foot_errors_[leg].max());
  summary.Set("path_error_max_m", path_errors_.max());
  summary.Set("path_foot_error_max_m", feet);
  summary.Set("drift_m", errors_.drift.max());
  summary.Set("height_drift_m", errors_.height_drift.max());
  return true;
}

namespace {

/// Compares the estimate of a constant force on a foot with the force.
class FootStepFigures final : public LogSink {
 public:
  FootStepFigures(const OutputPort<LegForceEstimate>& estimate, std::size_t leg, const Vec<3>& force_W,
                  double start)
      : estimate_(estimate), leg_(leg), force_W_(force_W), start_(start) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override {
    columns_ = Columns(names, estimate_, &LegForceEstimate::foot_force, kFeet[leg_]);
  }
  void Row(std::span<const double> row) override {
    if (row[0] < start_) return;
    const double share = VectorIn<3>(row, columns_).dot(force_W_) / force_W_.squaredNorm();
    shares_.Add(share);
    const bool settled = std::abs(share - 1) <= 0.02;
    if (!settled) settled_since_.reset();
    if (settled && !settled_since_) settled_since_ = row[0] - start_;
  }
  void AddTo(Summary& summary) const {
    summary.Set("force_settling_time_s", settled_since_);
    const std::optional<double> peak = shares_.max();
    summary.Set("force_overshoot_ratio", peak ? std::optional(std::max(0.0, *peak - 1)) : peak);
  }

 private:
  static constexpr Vec<3> FootForces::*kFeet[] = {&FootForces::front_left, &FootForces::front_right,
                                                  &FootForces::rear_left, &FootForces::rear_right};
  const OutputPort<LegForceEstimate>& estimate_;
  std::size_t leg_;
  Vec<3> force_W_;  // [N]
  double start_;    // [s]
  std::vector<std::size_t> columns_;
  Tally shares_;  // of the force that the estimate shows
  std::optional<double> settled_since_;
};

}  // namespace

void JudgeFootStep(const QuadrupedScenario& scenario, double duration, const QuadrupedWalk& loop,
                   Outputs& outputs) {
  const auto* const estimate = FindCurrent(loop.observer.leg_forces);
  if (estimate == nullptr || scenario.forces.size() != 1 || scenario.scale_forces) return;
  const ForceScenario& force = scenario.forces[0];
  if (force.on == Part::kTrunk || force.height != 0 || force.frequency_rad_per_s != 0 ||
      force.start_s + force.duration_s < duration)
    return;
  const Vec<3> force_W = force.factor * (Eigen::AngleAxisd(force.turn_rad, Vec<3>::UnitZ()) * force.force_N);
  if (force_W.isZero(0)) return;
  const auto leg = static_cast<std::size_t>(force.on) - static_cast<std::size_t>(Part::kFrontLeft);
  const auto sink = std::make_shared<FootStepFigures>(*estimate, leg, force_W, force.start_s);
  outputs.Judge(Hz(1000), {estimate}, sink, [sink](Summary& summary) { sink->AddTo(summary); });
}

}  // namespace tenon::apps
