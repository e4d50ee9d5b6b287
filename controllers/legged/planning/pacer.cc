#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/pacer.h>
#include <tenon/plants/model/vectors.h>

namespace tenon {
namespace {

constexpr double kPeakOfQuintic = 15.0 / 8;  // peak over mean speed of a quintic from rest to rest
constexpr double kFastest = 10;              // upper end of the search for the top speed [m/s]

}  // namespace

void PacerParams::Validate() const {
  CheckRanges(pace, "pace");
  CheckGravity(gravity);
}

Pacer::Pacer(const PacerParams& p)
    : LeafSystem(p),
      length_(ScaleOf(p.robot).length),
      foot_radius_(0),
      reach_(std::numeric_limits<double>::infinity()),
      drive_speed_(std::numeric_limits<double>::infinity()) {
  const NominalStance stance(p.robot);
  hip_height_ = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    hip_height_ +=
        (p.robot.HipPosition(leg, p.robot.stance) - p.robot.FootPosition(leg, p.robot.stance))[2] / kNumLegs;
    foot_radius_ = std::max(foot_radius_, stance.foot[leg].norm());
    reach_ = std::min(reach_, stance.reach[leg]);
    drive_speed_ = std::min(drive_speed_, p.robot.legs[leg].joints[1].speed_limit);
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

}  // namespace tenon
