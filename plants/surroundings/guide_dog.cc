#include <tenon/plants/surroundings/leash.h>
#include <tenon/plants/surroundings/obstacle_detector.h>
#include <tenon/plants/surroundings/person.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {
namespace {

constexpr double kDrawnRadius = 0.01;  // [m]

}  // namespace

LeashState Leash::CalcLeash(const LeggedState& robot, const PersonState& person, double nominal_length,
                            double stiffness, double dissipation) const {
  const Eigen::Vector3d arm = robot.R_WB() * params.attachment_B;
  const Eigen::Vector3d along = robot.p_WB + arm - person.hand_W;
  LeashState leash;
  leash.length = along.norm();
  if (leash.length > 0) leash.direction_W = along / leash.length;
  const double elongation = leash.length - nominal_length;
  const double rate = leash.direction_W.dot(robot.v_W + robot.w_W.cross(arm) - person.v_W);
  if (params.handle)
    leash.tension = stiffness * (elongation + params.damping_time * rate);
  else if (elongation > 0)
    leash.tension = stiffness * elongation * std::max(0.0, 1 + dissipation * rate);
  return leash;
}

ExternalForce Leash::CalcForce(const LeashState& leash) const {
  ExternalForce force;
  force.p_B = params.attachment_B;
  force.force_W = -leash.tension * leash.direction_W;
  return force;
}

Geometry Leash::MakeGeometry() {
  return {Shape::Segment(ShapeRole::kLine, "leash", kDrawnRadius, "N")};
}

void Leash::CalcGeometry(const PersonState& person, const LeashState& leash, Geometry* geometry) const {
  Shape& rod = (*geometry)[0];
  rod.p_W = person.hand_W;
  rod.vector_W = leash.length * leash.direction_W;
  rod.value = leash.tension;
}

namespace {

// Dimensions of the drawn head [m].
constexpr double kHeadRadius = 0.12, kHeadHeight = 1.6;
constexpr double kArrival = 1;  // duration of the deceleration at a destination [s]
enum PersonShape { kBodyShape, kHeadShape, kPathShape };

void CheckPhase(std::size_t i, const PersonPhase& phase) {
  Demand(phase.speed >= std::abs(phase.speed_amplitude),
         fmt::format("phases.{} has a speed of {} +- {} m/s, which must not become negative: give "
                     "another direction_rad to walk backwards",
                     i, phase.speed, phase.speed_amplitude));
  const bool pulls = phase.activity == Activity::kPull;
  Demand(!pulls || phase.speed == 0,
         fmt::format("phases.{} pulls and has a speed: give its force_N alone", i));
  Demand(pulls || phase.force == 0,
         fmt::format("phases.{} walks and has a force: give its speed_m_per_s alone", i));
}

/// u, the velocity at which a person of this intent walks.
Eigen::Vector2d WantedVelocity(const PersonIntent& intent, const LeashState& leash, double felt_tension) {
  const Eigen::Vector2d led = leash.direction_W.head<2>();
  const double length = led.norm();
  if (intent.activity == Activity::kFollow && length > 0)
    return intent.speed * std::clamp(leash.tension / felt_tension, 0.0, 1.0) / length * led;
  return intent.speed * intent.direction_W;
}

}  // namespace

void PersonParams::Validate() const {
  for (std::size_t i = 0; i < phases.size(); ++i) CheckPhase(i, phases[i]);
}

PersonIntent Person::CalcIntent(double time, const std::vector<PersonPhase>& phases, const PersonGoal& goal,
                                const PersonMotion& motion) const {
  if (goal.on) {
    const Eigen::Vector2d way = goal.place - motion.wanted;
    const double distance = way.norm();
    PersonIntent intent;
    intent.speed = std::min(goal.speed, distance / kArrival);
    if (distance > 0) intent.direction_W = way / distance;
    return intent;
  }
  // Tolerates the rounding of summed durations; ticks are exact multiples of the period.
  double since = time + 1e-6 * params.rate.period();
  for (const PersonPhase& phase : phases) {
    if (since < phase.duration) {
      PersonIntent intent;
      intent.activity = phase.activity;
      intent.speed = phase.speed + phase.speed_amplitude * std::sin(phase.angular_frequency * since);
      if (phase.activity != Activity::kFollow)
        intent.direction_W = {std::cos(phase.direction), std::sin(phase.direction)};
      intent.force = phase.force;
      return intent;
    }
    since -= phase.duration;
  }
  return {};
}

Vec<2> Person::CalcVelocity(const PersonIntent& intent, double acceleration, const PersonMotion& motion,
                            const LeashState& leash, double felt_tension, Vec<2>& last_velocity) const {
  if (intent.activity == Activity::kPull) return last_velocity = motion.v;
  const Eigen::Vector2d change = WantedVelocity(intent, leash, felt_tension) - last_velocity;
  const double most = acceleration * params.rate.period(), size = change.norm();
  return last_velocity += acceleration > 0 && size > most ? Vec<2>(most / size * change) : Vec<2>(change);
}

PersonMotion Person::CalcDerivative(const PersonMotion& motion, const PersonIntent& intent,
                                    const Vec<2>& velocity, double acceleration, const LeashState& leash,
                                    double mass, double damping, double stiffness,
                                    double felt_tension) const {
  const Eigen::Vector2d led = leash.direction_W.head<2>();
  const Eigen::Vector2d lean = motion.wanted - motion.x;
  Eigen::Vector2d force = leash.tension * led - damping * motion.v;
  PersonMotion rate;
  rate.x = motion.v;
  if (intent.activity == Activity::kPull) {
    force += intent.force * intent.direction_W;
    rate.wanted = motion.v - stiffness / damping * lean;
  } else {
    rate.wanted = acceleration > 0 ? velocity : Vec<2>(WantedVelocity(intent, leash, felt_tension));
    force += damping * rate.wanted + stiffness * lean;
  }
  rate.v = force / mass;
  return rate;
}

PersonState Person::CalcPerson(const PersonMotion& motion) const {
  PersonState person;
  person.p_W.head<2>() = motion.x;
  person.v_W.head<2>() = motion.v;
  person.hand_W << motion.x, params.hand_height;
  return person;
}

Geometry Person::MakeGeometry() {
  return {Shape::Capsule(ShapeRole::kOther, "person", Person::kRadius, Person::kHeight - 2 * Person::kRadius),
          Shape::Sphere(ShapeRole::kOther, "head", kHeadRadius),
          Shape::Trace(ShapeRole::kOther, "path of the person")};
}

void Person::CalcGeometry(const PersonMotion& motion, Geometry* geometry) const {
  (*geometry)[kBodyShape].p_W << motion.x, kHeight / 2;
  (*geometry)[kHeadShape].p_W << motion.x, kHeadHeight;
  (*geometry)[kPathShape].p_W << motion.x, 0;
}

bool ObstacleDetector::CalcObstacle(const LeggedState& state, double range, double half_width) const {
  const Eigen::Vector2d heading = state.R_WB().col(0).head<2>().normalized();
  for (const Obstacle& obstacle : params.obstacles) {
    const Eigen::Vector2d to = obstacle.centre - state.p_WB.head<2>();
    const double ahead = heading.dot(to), aside = heading[0] * to[1] - heading[1] * to[0];
    if (ahead > 0 && ahead - obstacle.radius < range && std::abs(aside) < half_width + obstacle.radius)
      return true;
  }
  return false;
}

Geometry ObstacleDetector::MakeGeometry(const ObstacleDetectorParams& params) {
  Geometry shapes;
  for (std::size_t i = 0; i < params.obstacles.size(); ++i) {
    const Obstacle& obstacle = params.obstacles[i];
    shapes.push_back(Shape::Cylinder(ShapeRole::kFixture, "obstacle " + std::to_string(i), obstacle.radius,
                                     Obstacle::kHeight));
    shapes.back().p_W << obstacle.centre, Obstacle::kHeight / 2;
  }
  return shapes;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::PersonMotion);
TENON_DEFINE_SIGNAL(tenon::PersonIntent);
TENON_DEFINE_SIGNAL(tenon::PersonGoal);
