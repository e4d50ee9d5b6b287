#include <tenon/apps/cdpr/cdpr_figures.h>

namespace tenon::apps {
namespace {

constexpr double kSettled = 0.02;  // threshold of the thesis [m]
constexpr double kTaken = 3;       // time after which the platform has settled under a load [s]

double Distance(std::span<const double> row, const std::vector<std::size_t>& a,
                const std::vector<std::size_t>& b) {
  return std::hypot(row[a[0]] - row[b[0]], row[a[1]] - row[b[1]], row[a[2]] - row[b[2]]);
}

}  // namespace

std::vector<const Source*> CdprFigures::Signals(const CdprLoop& loop) {
  const CdprPlant& plant = loop.world.plant;
  return Present<Source>({&plant.platform, &plant.euler, &plant.acceleration, &plant.cables, &loop.command,
                          &loop.reference.reference, &loop.world.payload.payload});
}

void CdprFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  const CdprPlant& plant = loop_.world.plant;
  const OutputPort<CdprReference>& reference = loop_.reference.reference;
  position_ = Columns(names, plant.platform, &PlatformState::p_WB);
  euler_ = Columns(names, plant.euler);
  a_W_ = Columns(names, plant.acceleration, &PlatformAcceleration::a_W);
  tensions_ = Columns(names, plant.cables, &CableSignals::tension);
  commands_ = Columns(names, loop_.command);
  ref_position_ = Columns(names, reference, &CdprReference::position);
  ref_euler_ = Columns(names, reference, &CdprReference::euler);
}

void CdprFigures::Row(std::span<const double> row) {
  for (const std::size_t column : tensions_) tension_.Add(row[column]);
  for (const std::size_t column : commands_) command_.Add(row[column]);
  oscillation_.Add(Distance(row, euler_, ref_euler_));
  const double error = Distance(row, position_, ref_position_);
  error_.Add(error);
  path_.Add(row[0], error, row[euler_[2]] - row[ref_euler_[2]]);
  if (row[0] >= loaded_from_ + kTaken && row[0] < settle_from_) {
    loaded_error_.Add(error);
    for (std::size_t i = 0; i < 3; ++i) loaded_euler_[i].Add(row[euler_[i]]);
  }
  acceleration_.Add(std::hypot(row[a_W_[0]], row[a_W_[1]], row[a_W_[2]]));

  const double dt = row[0] - last_time_;
  if (!last_tension_.empty() && dt > 0) {
    for (std::size_t i = 0; i < tensions_.size(); ++i)
      tension_rate_.Add((row[tensions_[i]] - last_tension_[i]) / dt);
  }
  last_time_ = row[0];
  last_tension_.resize(tensions_.size());
  for (std::size_t i = 0; i < tensions_.size(); ++i) last_tension_[i] = row[tensions_[i]];

  if (row[0] < settle_from_) return;
  if (settle_from_ > loaded_from_) release_error_.Add(error);
  const bool inside = std::abs(row[position_[0]] - row[ref_position_[0]]) <= kSettled &&
                      std::abs(row[position_[1]] - row[ref_position_[1]]) <= kSettled;
  if (!inside) settled_since_.reset();
  if (inside && !settled_since_) settled_since_ = row[0] - settle_from_;
}

std::optional<double> CdprFigures::LoadedSwing() const {
  double variance = 0;
  for (const Tally& angle : loaded_euler_) {
    if (!angle.rms()) return std::nullopt;
    variance += std::max(0.0, std::pow(*angle.rms(), 2) - std::pow(*angle.mean(), 2));
  }
  return std::sqrt(variance);
}

void CdprFigures::AddTo(Summary& summary) const {
  summary.Set("tension_min_N", tension_.min());
  summary.Set("tension_max_N", tension_.max());
  summary.Set("command_min_N", command_.min());
  summary.Set("command_max_N", command_.max());
  summary.Set("tension_rate_rms_N_per_s", tension_rate_.rms());
  summary.Set("euler_oscillation_rms_rad", oscillation_.rms());
  summary.Set("acceleration_rms_m_per_s2", acceleration_.rms());
  summary.Set("tracking_error_rms_m", error_.rms());
  summary.Set("loaded_error_rms_m", loaded_error_.rms());
  summary.Set("loaded_swing_rms_rad", LoadedSwing());
  summary.Set("settling_time_s", settled_since_);
  summary.Set("release_peak_m", release_error_.max());
}

void MpcFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  time_ = Column(names, FindCurrent(mpc_.diagnostics), &CdprMpcDiagnostics::solve_time);
  count_ = Column(names, FindCurrent(mpc_.diagnostics), &CdprMpcDiagnostics::fallbacks);
}

void MpcFigures::Row(std::span<const double> row) {
  if (!time_) return;
  times_.Add(row[*time_]);
  fallbacks_ = row[*count_];
}

void MpcFigures::AddTo(Summary& summary) const {
  summary.Set("mpc_time_median_us", Microseconds(times_.Quantile(0.5)));
  summary.Set("mpc_time_p99_us", Microseconds(times_.Quantile(0.99)));
  summary.Set("mpc_fallbacks", fallbacks_);
}

}  // namespace tenon::apps
