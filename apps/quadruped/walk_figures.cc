#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/controllers/legged/evaluation/tracking_error.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/quantile.h>

namespace tenon::apps {

std::vector<const Source*> WalkFigures::Signals(const QuadrupedWalk& loop) {
  std::vector<const Source*> signals{&loop.world.plant.state,
                                     &loop.world.plant.joint_torque,
                                     &loop.world.plant.foot_forces,
                                     &loop.world.plant.foot_slips,
                                     &loop.world.plant.external_wrench,
                                     &loop.world.plant.external_torque,
                                     &loop.observer.wrench,
                                     &loop.observer.leg_forces,
                                     &loop.locomotion.body,
                                     &loop.locomotion.schedule,
                                     &loop.errors.errors,
                                     &loop.errors.external_foot_forces};
  if (loop.estimator) signals.push_back(&loop.estimator->estimate);
  for (const Source*& signal : signals) signal = &signal->Current();
  return signals;
}

std::vector<const Source*> WalkFigures::Judged(const QuadrupedWalk& loop) {
  std::vector<const Source*> judged = Signals(loop);
  judged.push_back(&Solves(loop.locomotion)->Current());
  return judged;
}

void WalkFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  com_ = Columns(names, "loop.errors.errors.com");
  foot_ = Columns(names, "loop.errors.errors.foot");
  ground_force_ = Columns(names, "loop.errors.errors.ground_force");
  external_force_ = Columns(names, "loop.world.plant.external_wrench.force_W");
  estimated_force_ = Columns(names, "loop.observer.wrench.force_W");
  torque_ = Columns(names, "loop.world.plant.joint_torque");
  slip_ = Columns(names, "loop.world.plant.foot_slips");
  position_ = Columns(names, "loop.world.plant.state.p_WB");
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    contact_[leg] = Column(names, "loop.locomotion.schedule.legs." + std::to_string(leg) + ".state");
  solve_time_ = Column(names, "loop.locomotion.whole_body.diagnostics.solve_time");
  failures_ = Column(names, "loop.locomotion.whole_body.diagnostics.failures");
  estimate_.Begin(names);
}

void WalkFigures::Row(std::span<const double> row) {
  if (row[0] < from_) return;
  const auto norm = [&](const std::vector<std::size_t>& columns) {
    return std::hypot(row[columns[0]], row[columns[1]], row[columns[2]]);
  };
  const double com = norm(com_);
  ++rows_;
  com_max_ = std::max(com_max_, com);
  com_square_ += com * com;
  for (std::size_t i = 0; i < 3; ++i) {
    const double force = row[external_force_[i]];
    estimate_sum_[i] += row[estimated_force_[i]];
    estimate_square_ += (row[estimated_force_[i]] - force) * (row[estimated_force_[i]] - force);
  }
  for (const std::size_t column : torque_) torque_max_ = std::max(torque_max_, std::abs(row[column]));
  solve_times_.push_back(row[solve_time_]);
  failure_count_ = row[failures_];
  end_ = {row[position_[0]], row[position_[1]]};
  if (begin_.empty()) begin_ = end_;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) LegRow(row, leg);
  estimate_.Row(row);
  time_ = row[0];
}

void WalkFigures::LegRow(std::span<const double> row, std::size_t leg) {
  LegFigures& figures = legs_[leg];
  figures.foot_max = std::max(figures.foot_max, row[foot_[leg]]);
  const bool stance = row[contact_[leg]] == static_cast<double>(ContactState::kStance);
  if (stance && !figures.stance) {
    figures.touchdown = row[0];
    figures.slip = {};
  }
  if (!stance) figures.waiting.clear();
  figures.stance = stance;
  if (!stance || row[0] < figures.touchdown + kEdge) return;

  for (std::size_t i = 0; i < 3; ++i) figures.slip[i] += (row[0] - time_) * row[slip_[3 * leg + i]];
  figures.slip_max =
      std::max(figures.slip_max, std::hypot(figures.slip[0], figures.slip[1], figures.slip[2]));
  figures.waiting.push_back({row[0], row[ground_force_[leg]]});
  while (figures.waiting.front().time < row[0] - kEdge) {
    force_sum_ += figures.waiting.front().error;
    ++force_samples_;
    figures.waiting.pop_front();
  }
}

void WalkFigures::AddTo(Summary& summary) const {
  const double rows = static_cast<double>(std::max(rows_, 1L));
  const auto by_leg = [&](double LegFigures::*figure) {
    std::vector<std::pair<std::string, double>> values;
    for (std::size_t leg = 0; leg < kNumLegs; ++leg) values.emplace_back(kLegNames[leg], legs_[leg].*figure);
    return values;
  };
  summary.Set("judged_from_s", from_);
  summary.Set("com_error_max_m", com_max_);
  summary.Set("com_error_rms_m", std::sqrt(com_square_ / rows));
  summary.Set("foot_error_max_m", by_leg(&LegFigures::foot_max));
  summary.Set("grf_error_mean_N", force_samples_ > 0 ? force_sum_ / static_cast<double>(force_samples_) : 0);
  summary.Set(
      "force_estimate_mean_N",
      {{"x", estimate_sum_[0] / rows}, {"y", estimate_sum_[1] / rows}, {"z", estimate_sum_[2] / rows}});
  summary.Set("force_estimate_error_rms_N", std::sqrt(estimate_square_ / rows));
  summary.Set("slip_max_m", by_leg(&LegFigures::slip_max));
  summary.Set("torque_max_N_m", torque_max_);
  if (!begin_.empty()) summary.Set("distance_m", std::hypot(end_[0] - begin_[0], end_[1] - begin_[1]));
  summary.Set("qp_time_median_us", 1e6 * Quantile(solve_times_, 0.5));
  summary.Set("qp_time_p99_us", 1e6 * Quantile(solve_times_, 0.99));
  summary.Set("qp_failures", failure_count_);
  estimate_.AddTo(summary);
}

}  // namespace tenon::apps
