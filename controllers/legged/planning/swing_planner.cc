#include <tenon/controllers/legged/planning/swing_planner.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

namespace tenon {
namespace {

constexpr double kLeastWeight = 0.5;       // lower bound of the load on the feet, over the robot's weight
constexpr double kLeastRopedWeight = 0.1;  // its lower bound on ropes

/// The horizontal motion at time t after lift-off.
PlanarPoint Course(const SwingPlanner::LegMemory& leg, double duration, double t) {
  PlanarPoint course;
  const double begin = std::max(leg.from_time, leg.rise * duration);
  const double takes = (1 - leg.sink) * duration - begin;
  for (const int axis : {0, 1}) {
    const MotionPoint from{leg.from.position[axis], leg.from.velocity[axis], leg.from.acceleration[axis]};
    const MotionPoint now = Quintic(from, {leg.foothold[axis]}, takes, std::clamp(t - begin, 0.0, takes));
    course.position[axis] = now.position;
    course.velocity[axis] = now.velocity;
    course.acceleration[axis] = now.acceleration;
  }
  return course;
}

/// Limits the distance of a foot from its hip to `longest` by moving it horizontally. At constant height it
/// reaches the ground sooner than along the leg.
void KeepBent(const Eigen::Vector3d& hip, double longest, FootReference* foot) {
  const Eigen::Vector3d leg = foot->p_W - hip;
  if (leg.norm() <= longest) return;
  const double height = std::clamp(leg[2], -longest, longest);
  const double outward = std::sqrt(longest * longest - height * height);
  foot->p_W << hip.head<2>() + Shortened<2>(leg.head<2>(), outward), hip[2] + height;
  foot->v_W.head<2>().setZero();
  foot->a_W.head<2>().setZero();
  if (height != leg[2]) foot->v_W[2] = foot->a_W[2] = 0;
}

bool Searches(ContactState state) {
  return state == ContactState::kLate || state == ContactState::kSearching;
}

FootReference Swing(const SwingPlanner::LegMemory& leg, const StepProperties& step, double phase,
                    double duration) {
  const double t = phase * duration, half = duration / 2;
  const PlanarPoint course = Course(leg, duration, t);
  // Heights above a plane with the ground's slope through the lift-off point.
  const double z_begin = leg.lift_off[2], z_end = leg.ground.HeightAt(leg.lift_off.head<2>());
  const double z_top = std::max({z_begin, z_end, leg.highest}) +
                       (leg.high ? std::max(step.height, step.reflex.height) : step.height);
  // The acceleration at the top is the mean of those of cubics from rest to rest on both sides.
  const MotionPoint top{z_top, 0, -3 * (2 * z_top - z_begin - z_end) / (half * half)};
  const double v = step.touchdown_speed;
  const MotionPoint touchdown{z_end, -v, v * v / step.search_depth};
  const MotionPoint height =
      t < half ? Quintic({z_begin}, top, half, t) : Quintic(top, touchdown, half, t - half);
  FootReference foot;
  const Vec<2>& slope = leg.ground.slope;
  const double climbed = slope.dot(course.position - leg.lift_off.head<2>());
  foot.p_W << course.position, height.position + climbed;
  foot.v_W << course.velocity, height.velocity + slope.dot(course.velocity);
  foot.a_W << course.acceleration, height.acceleration + slope.dot(course.acceleration);
  return foot;
}

/// Lowers a foot whose target moves with the velocity `drift_W`.
FootReference Search(const SwingPlanner::LegMemory& leg, const StepProperties& step, const Vec<3>& drift_W) {
  const double v = step.touchdown_speed, depth = step.search_depth;
  const double decay = std::exp(-v * leg.searching / depth);
  FootReference foot;
  foot.p_W = leg.foothold;
  foot.p_W[2] -= depth * (1 - decay);
  foot.v_W = drift_W;
  foot.v_W[2] -= v * decay;
  foot.a_W[2] = v * v / depth * decay;
  return foot;
}

}  // namespace

void SwingPlanner::CalcPlan(const ContactSchedule& schedule, const PlanarPath& path,
                            const BodyReference& body, const LeggedState& state, const GroundPlane& ground,
                            const FootForces& foot_forces, const WrenchEstimate& wrench,
                            const WrenchEstimate& known_wrench, const FootholdPlan& planned,
                            const ElevationMap& map, const StepProperties& step, Memory& memory,
                            Memory* plan) const {
  const Eigen::Matrix3d R = state.R_WB();
  std::array<Eigen::Vector3d, kNumLegs> foot;
  for (int i = 0; i < kNumLegs; ++i) foot[i] = state.p_WB + R * params.robot.FootPosition(i, state.q);
  const Vec<2> shift = step.wrench_shift ? Vec<2>(Shift(wrench, step)) : Vec<2>(Vec<2>::Zero());
  const double gain = 1 - std::exp(-step.shift_bandwidth * params.rate.period());
  memory.shift += gain * (shift - memory.shift);
  PlanarPath below = BelowTheRobot(path, body, state, step);
  below.position_W += Displacement(known_wrench, ground.slope);
  // The feet of a robot in the air move with their hips: held in place, they would fold the falling legs.
  const bool flies = schedule.Count(ContactState::kSearching) == kNumLegs;
  for (int i = 0; i < kNumLegs; ++i) {
    LegMemory& leg = memory.legs[i];
    const ContactState before = leg.state;
    leg.state = schedule.legs[i].state;
    leg.hip = state.p_WB + R * params.robot.HipPosition(i, state.q);
    if (leg.state == ContactState::kStance) {
      if (before != leg.state || !memory.started) leg.foothold = foot[i];
      leg.planned = planned.position_W[i];
    } else if (leg.state == ContactState::kSwing) {
      const double swing = schedule.timing.swing, t = schedule.legs[i].phase * swing;
      // A leg that lands and lifts off again within a tick starts a new swing: its time decreases.
      const bool lifts_off = before != leg.state || !memory.started || t < leg.time;
      leg.time = t;
      const double late = step.retarget_phase * (1 - leg.sink);
      if (!lifts_off && (leg.blocked || schedule.legs[i].phase > late)) continue;
      Eigen::Vector2d back = Eigen::Vector2d::Zero();
      if (lifts_off) {
        leg.high = leg.blocked;
        leg.rise = leg.high ? step.reflex.rise_phase : 0;
        leg.sink = 0;
        leg.highest = foot[i][2];
        leg.lift_off = foot[i];
        leg.ground = ground;
        leg.ground.p_W[2] += params.robot.foot_radius / ground.Normal()[2];
      } else {
        back = PushedBack(i, schedule, leg, foot[i], foot_forces[i], step);
      }
      leg.blocked = !back.isZero(0);
      if (leg.blocked) leg.sink = 0;
      leg.from =
          lifts_off || leg.blocked ? PlanarPoint{.position = foot[i].head<2>()} : Course(leg, swing, t);
      leg.from_time = lifts_off ? 0 : t;
      const Eigen::Vector3d v_com = state.v_W + state.w_W.cross(R * stance.com_B);
      const Eigen::Vector2d v_error = (v_com - body.com_velocity_W).head<2>();
      leg.foothold.head<2>() = leg.blocked ? Eigen::Vector2d(leg.from.position + step.reflex.retreat * back)
                               : planned.planned
                                   ? Eigen::Vector2d(planned.position_W[i])
                                   : Foothold(i, schedule, below, ground.slope,
                                              Feedback(v_error, known_wrench, step) + memory.shift);
      // At lift-off, the plan may still be the last one in which the foot stands.
      const bool same = planned.position_W[i] == leg.planned;
      const bool renewed =
          leg.awaits && !same && !leg.blocked && schedule.legs[i].phase < step.reflex.rise_phase;
      leg.awaits = planned.planned && same && (lifts_off || leg.awaits);
      if (map.known()) {
        std::array<Vec<3>, kNumLegs - 1> others;
        for (int j = 0, n = 0; j < kNumLegs; ++j)
          if (j != i) others[n++] = memory.legs[j].foothold;
        PlaceOnMap(map, lifts_off || renewed, others, step, &leg);
        if (renewed && leg.rise > 0) leg.from = {.position = leg.from.position};  // straight up from here
      }
      leg.foothold[2] = leg.ground.HeightAt(leg.foothold.head<2>());
    } else {
      const bool goes_on = Searches(before) && memory.started;
      leg.searching = goes_on ? leg.searching + params.rate.period() : 0;
      if (!goes_on && leg.state == ContactState::kSearching) leg.foothold = foot[i];
      leg.lift_off = leg.foothold;
      if (goes_on && flies)
        leg.foothold += params.rate.period() * (state.v_W + state.w_W.cross(leg.hip - state.p_WB));
    }
  }
  memory.started = true;
  *plan = memory;
}

/// The horizontal direction in which an obstacle pushes a swing foot back, zero without an obstacle.
Eigen::Vector2d SwingPlanner::PushedBack(std::size_t i, const ContactSchedule& schedule, const LegMemory& leg,
                                         const Vec<3>& foot, const Vec<3>& force,
                                         const StepProperties& step) const {
  const double least = step.reflex.force * weight_;
  if (!step.reflex.enabled || leg.high || force.head<2>().norm() <= least) return Eigen::Vector2d::Zero();
  FootReference course = Swing(leg, step, schedule.legs[i].phase, schedule.timing.swing);
  KeepBent(leg.hip, stance.longest[i], &course);
  const Eigen::Vector2d off = (foot - course.p_W).head<2>(), back = off.normalized();
  const bool pushed = off.norm() > step.reflex.lag && force.head<2>().dot(back) > least;
  return pushed ? back : Eigen::Vector2d::Zero();
}

/// Moves the foothold to flat ground, and replaces the ground plane by a level one there. `decides` chooses
/// its level and the way to it anew.
void SwingPlanner::PlaceOnMap(const ElevationMap& map, bool decides, std::span<const Vec<3>> others,
                              const StepProperties& step, LegMemory* leg) const {
  const double radius = params.robot.foot_radius;
  const Eigen::Vector2d wanted = leg->foothold.head<2>();
  const std::optional<double> level = decides ? std::nullopt : std::optional(leg->ground.p_W[2] - radius);
  const MapPlace place = leg->blocked ? Survey(map, wanted, step.footing.radius)
                                      : FlatPlace(map, wanted, level, step.footing, others);
  leg->foothold.head<2>() = place.position;
  leg->ground = {.p_W = {place.position[0], place.position[1], place.height + radius}};
  if (!decides) return;
  leg->highest = HighestBetween(map, leg->lift_off.head<2>(), place.position) + radius;
  const bool climbs = leg->highest > leg->lift_off[2] + step.height / 2;
  const bool descends = leg->highest > leg->ground.p_W[2] + step.height / 2;
  leg->rise = leg->high || climbs ? step.reflex.rise_phase : 0;
  leg->sink = descends ? step.reflex.rise_phase : 0;
}

Eigen::Vector2d SwingPlanner::Feedback(const Eigen::Vector2d& v_error, const WrenchEstimate& known_wrench,
                                       const StepProperties& step) const {
  const Eigen::Vector2d feedback = step.velocity_feedback * v_error;
  if (!known_wrench.force_W.isZero(0)) return feedback;
  const double capture = std::sqrt(stance.com_height / params.gravity);
  return feedback +
         (capture - step.velocity_feedback) * (v_error - Shortened<2>(v_error, params.capture_speed));
}

Eigen::Vector2d SwingPlanner::Shift(const WrenchEstimate& wrench, const StepProperties& step) const {
  const Vec<3>&f = wrench.force_W, &t = wrench.torque_W;
  const double load = std::max(weight_ - f[2], kLeastWeight * weight_);
  const Eigen::Vector2d shift(stance.com_height * f[0] + t[1], stance.com_height * f[1] - t[0]);
  const double length = shift.norm() / load, free = step.free_shift;
  if (length <= free) return Eigen::Vector2d::Zero();
  return Shortened<2>(shift / load * (1 - free * free / (length * length)), step.largest_shift);
}

Eigen::Vector2d SwingPlanner::Displacement(const WrenchEstimate& known_wrench, const Vec<2>& slope) const {
  const Vec<3>&f = known_wrench.force_W, &t = known_wrench.torque_W;
  const double load = std::max(weight_ - f[2], kLeastRopedWeight * weight_);
  const Eigen::Matrix2d balance = load * Eigen::Matrix2d::Identity() + f.head<2>() * slope.transpose();
  return internal::Inverse<2>(balance) *
         Eigen::Vector2d(stance.com_height * f[0] + t[1], stance.com_height * f[1] - t[0]);
}

PlanarPath SwingPlanner::BelowTheRobot(const PlanarPath& path, const BodyReference& body,
                                       const LeggedState& state, const StepProperties& step) const {
  const Eigen::Matrix3d R = state.R_WB();
  const Eigen::Vector2d off = (state.p_WB + R * stance.com_B - body.com_W).head<2>();
  const Eigen::Vector3d forward = RotationFromQuaternion(body.q_WB).transpose() * R.col(0);
  const double turn = std::atan2(forward[1], forward[0]);
  PlanarPath below = path;
  below.position_W += off - Shortened<2>(off, step.free_offset);
  const double beyond = turn - std::clamp(turn, -step.free_turn, step.free_turn);
  below.yaw += beyond;
  below.velocity = Eigen::Rotation2Dd(-beyond) * path.velocity;  // keeps its direction in W
  return below;
}

Eigen::Vector2d SwingPlanner::Foothold(std::size_t leg, const ContactSchedule& schedule,
                                       const PlanarPath& path, const Eigen::Vector2d& slope,
                                       const Eigen::Vector2d& correction) const {
  const double touchdown = schedule.legs[leg].time_to_touchdown;
  const auto nominal = [&](double t) -> Eigen::Vector2d {
    const PlanarPath there = path.At(t);
    return there.position_W + FootprintOnSlope(slope, there.yaw) * stance.foot[leg];
  };
  const Eigen::Vector2d at_touchdown = nominal(touchdown);
  const Eigen::Vector2d wanted = nominal(touchdown + schedule.timing.leg_stance() / 2) + correction;
  return at_touchdown + Shortened<2>(wanted - at_touchdown, stance.reach[leg]);
}

FeetReference SwingPlanner::CalcFeet(const ContactSchedule& schedule, const Memory& plan, double clock_rate,
                                     const StepProperties& step) const {
  FeetReference reference;
  for (std::size_t i = 0; i < kNumLegs; ++i) {
    const LegMemory& leg = plan.legs[i];
    FootReference& foot = reference.feet[i];
    if (leg.state == ContactState::kSwing) {
      foot = Swing(leg, step, schedule.legs[i].phase, schedule.timing.swing);
      foot.v_W *= clock_rate;
      foot.a_W *= clock_rate * clock_rate;
    } else if (Searches(leg.state)) {
      // A searching foot has no lift-off: `lift_off` is where its target was one tick ago.
      foot = Search(leg, step, (leg.foothold - leg.lift_off) / params.rate.period());
    } else {
      foot.p_W = leg.foothold;
      continue;
    }
    KeepBent(leg.hip, stance.longest[i], &foot);
  }
  return reference;
}

std::array<Vec<3>, kNumLegs> SwingPlanner::CalcFootholds(const Memory& plan) const {
  std::array<Vec<3>, kNumLegs> footholds;
  for (std::size_t i = 0; i < kNumLegs; ++i) footholds[i] = plan.legs[i].foothold;
  return footholds;
}

}  // namespace tenon
