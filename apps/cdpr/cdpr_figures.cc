#include <tenon/apps/cdpr/cdpr_figures.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/quantile.h>

namespace tenon::apps {
namespace {

constexpr double kSettled = 0.02;  // m, the thesis's threshold

double SquaredDistance(std::span<const double> row, const std::vector<std::size_t>& a,
                       const std::vector<std::size_t>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(row[a[i]] - row[b[i]], 2);
  return sum;
}

double Rms(double squares, long count) {
  return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0;
}

void Widen(std::span<const double> row, const std::vector<std::size_t>& columns, double& low, double& high) {
  for (const std::size_t column : columns) {
    low = std::min(low, row[column]);
    high = std::max(high, row[column]);
  }
}

}  // namespace

std::vector<const Source*> CdprFigures::Signals(const CdprLoop& loop) {
  return {&loop.plant.platform, &loop.plant.euler,         &loop.plant.acceleration, &loop.plant.cables,
          &loop.command,        &loop.reference.reference, &loop.payload.payload};
}

void CdprFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  position_ = Columns(names, "loop.plant.platform.p_WB");
  euler_ = Columns(names, "loop.plant.euler");
  acceleration_ = Columns(names, "loop.plant.acceleration.a_W");
  tension_ = Columns(names, "loop.plant.cables.tension");
  command_ = Columns(names, "loop.command");
  ref_position_ = Columns(names, "loop.reference.reference.position");
  ref_euler_ = Columns(names, "loop.reference.reference.euler");
  tension_min_ = command_min_ = std::numeric_limits<double>::infinity();
  tension_max_ = command_max_ = -tension_min_;
}

void CdprFigures::Row(std::span<const double> row) {
  ++rows_;
  Widen(row, tension_, tension_min_, tension_max_);
  Widen(row, command_, command_min_, command_max_);
  euler_square_ += SquaredDistance(row, euler_, ref_euler_);
  error_square_ += SquaredDistance(row, position_, ref_position_);
  for (std::size_t i = 0; i < 3; ++i) acceleration_square_ += row[acceleration_[i]] * row[acceleration_[i]];

  const double dt = row[0] - last_time_;
  if (!last_tension_.empty() && dt > 0) {
    for (std::size_t i = 0; i < tension_.size(); ++i) {
      rate_square_ += std::pow((row[tension_[i]] - last_tension_[i]) / dt, 2);
      ++rate_rows_;
    }
  }
  last_time_ = row[0];
  last_tension_.resize(tension_.size());
  for (std::size_t i = 0; i < tension_.size(); ++i) last_tension_[i] = row[tension_[i]];

  if (row[0] < settle_from_) return;
  const bool inside = std::abs(row[position_[0]] - row[ref_position_[0]]) <= kSettled &&
                      std::abs(row[position_[1]] - row[ref_position_[1]]) <= kSettled;
  if (inside && !settled_) settled_since_ = row[0];
  settled_ = inside;
}

double CdprFigures::tension_rate_rms() const {
  return Rms(rate_square_, rate_rows_);
}
double CdprFigures::euler_oscillation_rms() const {
  return Rms(euler_square_, rows_);
}
double CdprFigures::acceleration_rms() const {
  return Rms(acceleration_square_, rows_);
}
double CdprFigures::tracking_error_rms() const {
  return Rms(error_square_, rows_);
}

std::optional<double> CdprFigures::settling_time() const {
  if (!settled_) return std::nullopt;
  return settled_since_ - settle_from_;
}

void MpcFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  time_ = Column(names, "loop.mpc.diagnostics.solve_time");
  count_ = Column(names, "loop.mpc.diagnostics.fallbacks");
}

void MpcFigures::Row(std::span<const double> row) {
  times_.push_back(row[time_]);
  fallbacks_ = row[count_];
}

double MpcFigures::time_quantile(double share) const {
  return Quantile(times_, share);
}

}  // namespace tenon::apps
