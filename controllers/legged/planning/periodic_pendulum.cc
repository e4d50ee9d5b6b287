#include <tenon/controllers/legged/planning/periodic_pendulum.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

namespace tenon {

void PeriodicPendulum::Begin(const PlanarPath& path, double frequency) {
  path_ = path;
  frequency_ = frequency;
  cycle_ = 0;
  num_phases_ = 0;
}

void PeriodicPendulum::Add(double duration, const Eigen::Vector2d& zmp_W) {
  if (num_phases_ == kMaxPhases) {
    throw RunError("a gait of more than " + std::to_string(kMaxPhases) +
                   " phases: let more legs swing together");
  }
  if (duration <= 0) return;
  Phase& phase = phases_[num_phases_++];
  phase.duration = duration;
  phase.zmp = path_.Heading().transpose() * (zmp_W - path_.position_W);
  cycle_ += duration;
}

// Computed in the frame of the path's start, so that precision does not depend on the distance from the
// origin.
void PeriodicPendulum::Solve() {
  if (num_phases_ == 0) return;
  const PlanarPath end = path_.At(cycle_);
  const Eigen::Matrix2d R = path_.Heading().transpose() * end.Heading();
  const Eigen::Vector2d d = path_.Heading().transpose() * (end.position_W - path_.position_W);
  const double whole = std::exp(-frequency_ * cycle_);
  const auto decay = [&](int k) { return std::exp(-frequency_ * phases_[k].duration); };
  // Contributions of the ZMPs to a, backwards in time, and to b, forwards.
  Eigen::Vector2d a = Eigen::Vector2d::Zero(), b = Eigen::Vector2d::Zero();
  for (int k = num_phases_; k-- > 0;) {
    const Vec<2>& p = phases_[k].zmp;
    a = p + decay(k) * (a - p);
  }
  for (int k = 0; k < num_phases_; ++k) {
    const Vec<2>& p = phases_[k].zmp;
    b = p + decay(k) * (b - p);
  }
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  a = internal::Inverse<2>(I - whole * R) *
      (a + whole * d);  // at the start: a = whole (R a + d) + contribution of the ZMPs
  b = internal::Inverse<2>(R - whole * I) *
      (b - d);  // at the end: R b + d = whole b + contribution of the ZMPs
  a = R * a + d;
  for (int k = num_phases_; k-- > 0;) {
    Phase& phase = phases_[k];
    phase.a_end = a;
    a = phase.zmp + decay(k) * (a - phase.zmp);
  }
  for (int k = 0; k < num_phases_; ++k) {
    Phase& phase = phases_[k];
    phase.b_begin = b;
    b = phase.zmp + decay(k) * (b - phase.zmp);
  }
}

PeriodicPendulum::Place PeriodicPendulum::Find(double t) const {
  Place place{nullptr, t, path_};
  if (num_phases_ == 0) return place;
  const double cycles = std::floor(t / cycle_);
  place.t -= cycles * cycle_;
  place.beginning = path_.At(cycles * cycle_);
  std::size_t k = 0;
  while (k + 1 < static_cast<std::size_t>(num_phases_) && place.t >= phases_[k].duration)
    place.t -= phases_[k++].duration;
  place.phase = &phases_[k];
  return place;
}

PlanarPoint PeriodicPendulum::At(double t) const {
  const Place place = Find(t);
  PlanarPoint point;
  if (place.phase == nullptr) {
    point.position = path_.position_W;
    return point;
  }
  const Phase& phase = *place.phase;
  const double w = frequency_;
  const Eigen::Vector2d a = std::exp(-w * (phase.duration - place.t)) * (phase.a_end - phase.zmp);
  const Eigen::Vector2d b = std::exp(-w * place.t) * (phase.b_begin - phase.zmp);
  const Eigen::Matrix2d R = place.beginning.Heading();
  point.position = place.beginning.position_W + R * (phase.zmp + (a + b) / 2);
  point.velocity = R * (a - b) * (w / 2);
  point.acceleration = R * (a + b) * (w * w / 2);
  return point;
}

Eigen::Vector2d PeriodicPendulum::ZmpAt(double t) const {
  const Place place = Find(t);
  if (place.phase == nullptr) return path_.position_W;
  return place.beginning.position_W + place.beginning.Heading() * place.phase->zmp;
}

}  // namespace tenon
