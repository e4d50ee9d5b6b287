#include <tenon/apps/common/customisation.h>
#include <tenon/apps/guide_dog/guide_dog_figures.h>
#include <tenon/apps/quadruped/limit_figures.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/diagrams/evaluation/tracking_error.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

constexpr std::size_t kSecond = 1000;  // rows
constexpr double kStandingTime = 0.5;  // [s]

bool Is(double value, auto enumerator) {
  return value == static_cast<double>(enumerator);
}

constexpr double kTogether = 1e-6;  // distance below which leash and robot touch [m]
constexpr double kDepth = 10;       // depth of the axes of person and pillars, below all ground [m]

const char kPerson[] = "the person", kLeash[] = "the leash";

std::string NameOf(int leg) {
  return leg < 0 ? "the trunk" : std::string("the leg ") + kLegNames[static_cast<std::size_t>(leg)];
}

/// The horizontal distance between a vertical line and the part of the segment from `a` to `b` below `top`;
/// infinite if no part of it is.
double DistanceBelow(double top, Eigen::Vector3d a, Eigen::Vector3d b, const Eigen::Vector2d& line) {
  if (a[2] > b[2]) std::swap(a, b);
  if (a[2] > top) return std::numeric_limits<double>::infinity();
  if (b[2] > top) b = a + (top - a[2]) / (b[2] - a[2]) * (b - a);
  const Eigen::Vector2d along = (b - a).head<2>(), to = line - a.head<2>();
  const double squared = along.squaredNorm();
  const double part = squared > 0 ? std::clamp(to.dot(along) / squared, 0.0, 1.0) : 0;
  return (to - part * along).norm();
}

}  // namespace

GuideDogFigures::GuideDogFigures(const GuideDog& loop, const std::optional<GuideDogTask>& task)
    : loop_(loop),
      task_(task),
      desired_tension_(
          CurrentAs<LeafSystem<AdmittanceFilterParams>>(loop.admittance).params.gains.desired_tension),
      threshold_(CurrentAs<LeafSystem<SupervisorParams>>(loop.supervisor).params.gains.threshold) {
  if (!task_) return;
  const bool supervised = FindCurrent(loop.supervisor.status) != nullptr;
  double end = 0;  // of a phase [s]
  for (const PersonPhase& phase : CurrentAs<LeafSystem<PersonParams>>(loop.person).params.phases) {
    end += phase.duration;
    const bool follows = phase.activity == Activity::kFollow && phase.speed > 0;
    if (follows && !tightens_.due) tightens_.due = end;
    crosses_.due = follows && supervised ? std::optional(end + task_->crossing) : std::nullopt;
    if (phase.activity != Activity::kPull || !supervised) continue;
    directed_.due = end;
    restarts_.due = end + task_->restart;
  }
}

std::vector<const Source*> GuideDogFigures::Signals(const GuideDog& loop) {
  std::vector<const Source*> signals{&loop.leash.leash,
                                     &loop.person.person,
                                     &loop.person.intent,
                                     &loop.supervisor.status,
                                     &loop.admittance.motion,
                                     &loop.observer.wrench,
                                     &loop.obstacles.obstacle,
                                     &loop.world.plant.state,
                                     &loop.world.plant.joint_torque,
                                     &loop.world.plant.external_wrench,
                                     &loop.world.plant.foot_forces,
                                     &loop.world.plant.foot_slips,
                                     &loop.locomotion.body,
                                     &loop.locomotion.schedule,
                                     &loop.errors.errors};
  return Present(WalkFigures::WithOptions(std::move(signals), loop));
}

std::vector<const Source*> GuideDogFigures::Judged(const GuideDog& loop) {
  return WalkFigures::WithSolvers(Signals(loop), loop);
}

std::vector<const OutputPort<Geometry>*> GuideDogFigures::Shapes(const GuideDog& loop) {
  return Present<OutputPort<Geometry>>({&loop.world.plant.geometry, &loop.view.geometry,
                                        &loop.person.geometry, &loop.leash.geometry,
                                        &loop.obstacles.geometry});
}

void GuideDogFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  leash_.Begin(names, &loop_.leash.leash);
  state_.Begin(names, &loop_.world.plant.state);
  mode_ = Column(names, FindCurrent(loop_.supervisor.status), &GuideStatus::mode);
  activity_ = Column(names, FindCurrent(loop_.person.intent), &PersonIntent::activity);
  speed_ = Column(names, FindCurrent(loop_.person.intent), &PersonIntent::speed);
  obstacle_ = Column(names, loop_.obstacles.obstacle);
}

void GuideDogFigures::Row(std::span<const double> row) {
  const LeashState leash = leash_.In(row);
  const LeggedState state = state_.In(row);
  LeashRow(row, leash);
  StopRow(row, leash.tension, state.v_W);
  HeadingRow(row, leash.direction_W, state.R_WB());
  if (mode_) last_mode_ = row[*mode_];
  time_ = row[0];
}

void GuideDogFigures::LeashRow(std::span<const double> row, const LeashState& leash) {
  tensions_.Add(leash.tension);
  if (leash.tension > 0) tightens_.Meet(row[0]);
  if (leash.tension > threshold_ && crosses_.due && row[0] >= *crosses_.due - task_->crossing)
    crosses_.Meet(row[0]);

  if (!mode_ || !activity_) return;
  const bool together =
      Is(row[*mode_], GuideMode::kMove) && Is(row[*activity_], Activity::kFollow) && row[*speed_] > 0;
  if (together) {
    tensions_walking_.Add(leash.tension);
    distances_walking_.Add(leash.length);
    slack_.Add(leash.tension > 0 ? 0 : 1);
  }
  leads_ = together && (leads_ || leash.tension >= desired_tension_);
  if (!leads_) return;
  tensions_leading_.Add(leash.tension);
  distances_leading_.Add(leash.length);
}

void GuideDogFigures::StopRow(std::span<const double> row, double tension, const Vec<3>& v_W) {
  if (stop_delay_ || !mode_) return;
  const bool moves = !Is(last_mode_, GuideMode::kStop);
  if (!cause_ && moves && (tension > threshold_ || row[obstacle_] != 0)) cause_ = row[0];
  if (cause_ && moves && tension <= threshold_ && row[obstacle_] == 0) cause_.reset();
  if (!cause_) return;
  if (std::hypot(v_W[0], v_W[1]) >= kStanding) {
    standing_.reset();
    return;
  }
  if (!standing_) standing_ = row[0];
  if (row[0] - *standing_ >= kStandingTime) stop_delay_ = *standing_ - *cause_;
}

void GuideDogFigures::HeadingRow(std::span<const double> row, const Vec<3>& direction_W,
                                 const Eigen::Matrix3d& R) {
  if (headings_.size() == kSecond) headings_.pop_front();
  headings_.emplace_back(R(0, 0), R(1, 0));
  if (mode_ && Is(last_mode_, GuideMode::kStop) && Is(row[*mode_], GuideMode::kTurn)) {
    pull_yaw_ = std::atan2(-direction_W[1], -direction_W[0]);
    directed_.Meet(row[0]);
  }
  if (!task_ || restarts_.met_at || !pull_yaw_) return;
  if (!Is(row[*mode_], GuideMode::kMove)) {
    moves_since_.reset();
  } else if (!moves_since_) {
    moves_since_ = row[0];
  } else if (row[0] - *moves_since_ >= 1) {
    if (*HeadingError() <= task_->heading) restarts_.Meet(row[0]);
    moves_since_ = row[0];
  }
}

std::optional<double> GuideDogFigures::HeadingError() const {
  if (!pull_yaw_) return std::nullopt;
  Vec<2> sum = Vec<2>::Zero();
  for (const Vec<2>& heading : headings_) sum += heading;
  return 180 / std::numbers::pi *
         std::abs(std::remainder(std::atan2(sum[1], sum[0]) - *pull_yaw_, 2 * std::numbers::pi));
}

void GuideDogFigures::AddTo(Summary& summary) const {
  summary.Set("tension_mean_N", tensions_leading_.mean());
  summary.Set("tension_max_N", tensions_.max());
  summary.Set("distance_mean_m", distances_leading_.mean());
  summary.Set("distance_min_m", distances_leading_.min());
  summary.Set("distance_max_m", distances_leading_.max());
  summary.Set("slack_ratio", slack_.mean());
  summary.Set("tension_walking_mean_N", tensions_walking_.mean());
  summary.Set("distance_walking_mean_m", distances_walking_.mean());
  summary.Set("distance_walking_min_m", distances_walking_.min());
  summary.Set("distance_walking_max_m", distances_walking_.max());
  summary.Set("stop_delay_s", stop_delay_);
  const std::optional<double> heading_error = HeadingError();
  summary.Set("heading_error_deg", heading_error);
  for (const Condition& condition : {tightens_, crosses_, directed_, restarts_}) summary.Require(condition);
  if (!task_) return;
  summary.Limit("stop_delay_s", {.high = task_->stop});
  if (stop_delay_.value_or(cause_ ? time_ - *cause_ : 0) > task_->stop)
    summary.Break(*cause_ + task_->stop, fmt::format("the robot did not stop within {} s", task_->stop));
  if (!restarts_.met_at) return;
  summary.Limit("heading_error_deg", {.high = task_->heading});
  if (*heading_error > task_->heading)
    summary.Break(time_,
                  fmt::format("the robot left the direction of the pull by {:.3g} degrees, more than {}",
                              *heading_error, task_->heading));
}

CollisionFigures::CollisionFigures(const GuideDog& loop)
    : loop_(loop),
      known_(KnowsLimits<QuadrupedPlantParams>(loop.world.plant)),
      clearance_(MakeClearance(loop.world.plant)),
      obstacles_(CurrentAs<LeafSystem<ObstacleDetectorParams>>(loop.obstacles).params.obstacles),
      attachment_B_(CurrentAs<LeafSystem<LeashParams>>(loop.leash).params.attachment_B) {
  for (std::size_t i = 0; i < obstacles_.size(); ++i) names_.push_back("obstacle " + std::to_string(i));
}

std::vector<const Source*> CollisionFigures::Signals(const GuideDog& loop) {
  return Present<Source>({&loop.world.plant.state, &loop.person.person});
}

void CollisionFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  state_.Begin(names, &loop_.world.plant.state);
  person_.Begin(names, &loop_.person.person);
}

void CollisionFigures::Row(std::span<const double> row) {
  const LeggedState x = state_.In(row);
  const PersonState person = person_.In(row);
  const Eigen::Vector3d person_W = person.p_W, hand_W = person.hand_W;
  RobotRow(row[0], x, person_W, Person::kHeight - Person::kRadius, Person::kRadius, kPerson, &to_person_);

  const Eigen::Vector3d attachment_W = x.p_WB + x.R_WB() * attachment_B_;
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    const auto& [centre, radius] = obstacles_[i];
    RobotRow(row[0], x, {centre[0], centre[1], 0}, Obstacle::kHeight, radius, names_[i], &to_obstacles_);
    const auto check = [&](const char* name, double distance) {
      to_obstacles_.Add(distance);
      if (distance < 0) Collide(row[0], name, names_[i], -distance);
    };
    check(kPerson, (person_W.head<2>() - centre).norm() - radius - Person::kRadius);
    check(kLeash, DistanceBelow(Obstacle::kHeight, attachment_W, hand_W, centre) - radius);
  }
  LeashRow(row[0], x, hand_W);
}

/// Checks the robot against a capsule on the vertical axis below the height `top` at `place_W`.
void CollisionFigures::RobotRow(double time, const LeggedState& x, const Eigen::Vector3d& place_W, double top,
                                double radius, const std::string& name, Tally* distances) {
  if (!known_) return;
  // Bodies that are too far away to be the nearest need no closer look.
  const double least = (place_W - x.p_WB).head<2>().norm() - clearance_.reach() - radius;
  if (least > 0 && distances->min() && least >= *distances->min()) return;
  const Eigen::Matrix3d R_BW = x.R_WB().transpose();
  const Eigen::Vector3d low_W(place_W[0], place_W[1], -kDepth), up_W(0, 0, kDepth + top);
  const QuadrupedClearances::Gap gap = clearance_.To(x.q, R_BW * (low_W - x.p_WB), R_BW * up_W);
  const double distance = gap.distance - radius;
  distances->Add(distance);
  if (distance < 0) Collide(time, NameOf(gap.leg), name, -distance);
}

void CollisionFigures::LeashRow(double time, const LeggedState& x, const Eigen::Vector3d& hand_W) {
  if (!known_) return;
  const Eigen::Vector3d start_B = clearance_.OnTrunk(attachment_B_);
  const Eigen::Vector3d hand_B = x.R_WB().transpose() * (hand_W - x.p_WB);
  const QuadrupedClearances::Gap gap = clearance_.To(x.q, start_B, hand_B - start_B, kSoft);
  if (gap.distance < kTogether) Collide(time, kLeash, NameOf(gap.leg), -gap.distance);
}

void CollisionFigures::Collide(double time, const std::string& one, const std::string& other, double depth) {
  breaches_.Add(time, one + " and " + other + " collided",
                depth > 0 ? fmt::format("they overlap by {:.3g} m", depth) : "they touch");
}

void CollisionFigures::AddTo(Summary& summary) const {
  summary.Set("person_clearance_min_m", to_person_.min(), {.low = 0});
  summary.Set("obstacle_clearance_min_m", to_obstacles_.min(), {.low = 0});
  breaches_.AddTo(summary);
}

}  // namespace tenon::apps
