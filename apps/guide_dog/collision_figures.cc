#include <tenon/apps/common/customisation.h>
#include <tenon/apps/guide_dog/collision_figures.h>
#include <tenon/apps/quadruped/limit_figures.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

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
  const OutputPort<LeggedState>& state = loop_.world.plant.state;
  position_ = Columns(names, state, &LeggedState::p_WB);
  attitude_ = Columns(names, state, &LeggedState::q_WB);
  q_ = Columns(names, state, &LeggedState::q);
  person_ = Columns(names, loop_.person.person, &PersonState::p_W);
  hand_ = Columns(names, loop_.person.person, &PersonState::hand_W);
}

void CollisionFigures::Row(std::span<const double> row) {
  LeggedState x;
  x.p_WB = VectorIn<3>(row, position_);
  x.q_WB = VectorIn<4>(row, attitude_);
  x.q = VectorIn<kNumJoints>(row, q_);
  const Eigen::Vector3d person_W = VectorIn<3>(row, person_), hand_W = VectorIn<3>(row, hand_);
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
