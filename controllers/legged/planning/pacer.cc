#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/pacer.h>
#include <tenon/controllers/legged/planning/periodic_pendulum.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <fmt/core.h>

namespace tenon {
namespace {

constexpr double kPeakOfQuintic = 15.0 / 8;  // peak over mean speed of a quintic from rest to rest
constexpr double kFastest = 10;              // upper end of the search for the top speed [m/s]

}  // namespace

void PacerParams::Validate() const {
  CheckRanges(pace, "pace");
  Demand(gravity > 0, fmt::format("gravity is {} m/s^2: it must be positive", gravity));
}

Pacer::Pacer(const PacerParams& p)
    : LeafSystem(p),
      length_(ScaleOf(p.robot).length),
      foot_radius_(0),
      reach_(std::numeric_limits<double>::infinity()),
      drive_speed_(std::numeric_limits<double>::infinity()) {
  const NominalStance stance(p.robot);
  hip_height_ = 0;
  for (std::size_t i = 0; i < kNumLegs; ++i) {
    const int leg = static_cast<int>(i);
    hip_height_ +=
        (p.robot.HipPosition(leg, p.robot.stance) - p.robot.FootPosition(leg, p.robot.stance))[2] / kNumLegs;
    foot_radius_ = std::max(foot_radius_, stance.foot[i].norm());
    reach_ = std::min(reach_, stance.reach[i]);
    drive_speed_ = std::min(drive_speed_, p.robot.legs[i].joints[1].speed_limit);
  }
  for (const Gait gait : {Gait::kCrawl, Gait::kTrot, Gait::kPace, Gait::kGallop}) {
    table_[static_cast<std::size_t>(gait)] = p.gaits[gait].Timing();
    double slow = 0, fast = kFastest;
    for (int i = 0; i < 40; ++i) {
      const double middle = (slow + fast) / 2;
      (Feasible(gait, middle) ? slow : fast) = middle;
    }
    top_speed_[static_cast<std::size_t>(gait)] = slow;
  }
}

GaitTiming Pacer::TimingAt(Gait gait, double speed) const {
  GaitTiming timing = table_[static_cast<std::size_t>(gait)];
  if (timing.num_steps < 2 || Flies(timing) || speed <= 0) return timing;
  const PaceProperties& pace = params.pace;
  const double g = params.gravity, h = hip_height_;
  const double stride = pace.stride * h * std::pow(speed * speed / (g * h), 0.3);
  const double cycle = std::min(timing.cycle(), stride / speed), way = speed * cycle;
  const double shorter = cycle / timing.cycle();
  for (double& delay : timing.delay) delay *= shorter;
  const double step = cycle / timing.num_steps - (timing.span() - timing.swing),
               least = pace.least_stance * std::sqrt(length_ / g);
  const double slowest = std::max(way / (pace.swing_speed * std::sqrt(g * length_)),
                                  kPeakOfQuintic * way / (pace.drive_speed * drive_speed_ * h + speed));
  timing.swing = std::min(std::max(timing.swing, slowest), std::max(step - least, step / 2));
  timing.stance = step - timing.swing;
  return timing;
}

bool Pacer::Feasible(Gait gait, double speed) const {
  const GaitTiming timing = TimingAt(gait, speed);
  const double swing = kPeakOfQuintic * speed * timing.cycle() / timing.swing - speed;
  return speed * timing.leg_stance() <= 2 * params.pace.reach * reach_ &&
         swing <= params.pace.drive_speed * drive_speed_ * hip_height_;
}

double Pacer::SpeedOfFeet(const Vec<3>& velocity) const {
  return velocity.head<2>().norm() + std::abs(velocity[2]) * foot_radius_;
}

WalkCommand Pacer::CalcPaced(const WalkCommand& command, Progress& progress) const {
  const double dt = params.rate.period();
  Vec<3> wanted(command.forward, command.left, command.yaw_rate);
  const double speed = SpeedOfFeet(wanted), top = TopSpeed(command.gait);
  if (speed > top) wanted *= top / speed;
  const double most = params.pace.acceleration * params.gravity * dt;
  const double turn = params.pace.yaw_acceleration * dt;
  const Eigen::Vector2d change = (wanted - progress.velocity).head<2>();
  progress.velocity.head<2>() += Shortened<2>(change, most);
  progress.velocity[2] += std::clamp(wanted[2] - progress.velocity[2], -turn, turn);
  if (SpeedOfFeet(progress.velocity) <= TopSpeed(command.gait) + 1e-9) progress.gait = command.gait;
  WalkCommand paced = command;
  paced.gait = progress.gait;
  paced.forward = progress.velocity[0];
  paced.left = progress.velocity[1];
  paced.yaw_rate = progress.velocity[2];
  return paced;
}

GaitTiming Pacer::CalcTiming(const WalkCommand& paced) const {
  return TimingAt(paced.gait, SpeedOfFeet({paced.forward, paced.left, paced.yaw_rate}));
}

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
  Phase& phase = phases_[static_cast<std::size_t>(num_phases_++)];
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
  const auto decay = [&](int k) {
    return std::exp(-frequency_ * phases_[static_cast<std::size_t>(k)].duration);
  };
  // Contributions of the ZMPs to a, backwards in time, and to b, forwards.
  Eigen::Vector2d a = Eigen::Vector2d::Zero(), b = Eigen::Vector2d::Zero();
  for (int k = num_phases_; k-- > 0;) {
    const Vec<2>& p = phases_[static_cast<std::size_t>(k)].zmp;
    a = p + decay(k) * (a - p);
  }
  for (int k = 0; k < num_phases_; ++k) {
    const Vec<2>& p = phases_[static_cast<std::size_t>(k)].zmp;
    b = p + decay(k) * (b - p);
  }
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  a = internal::Inverse<2>(I - whole * R) *
      (a + whole * d);  // at the start: a = whole (R a + d) + contribution of the ZMPs
  b = internal::Inverse<2>(R - whole * I) *
      (b - d);  // at the end: R b + d = whole b + contribution of the ZMPs
  a = R * a + d;
  for (int k = num_phases_; k-- > 0;) {
    Phase& phase = phases_[static_cast<std::size_t>(k)];
    phase.a_end = a;
    a = phase.zmp + decay(k) * (a - phase.zmp);
  }
  for (int k = 0; k < num_phases_; ++k) {
    Phase& phase = phases_[static_cast<std::size_t>(k)];
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
  while (k + 1 < static_cast<std::size_t>(num_phases_) && place.t >= phases_[k].duration) {
    place.t -= phases_[k++].duration;
  }
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
