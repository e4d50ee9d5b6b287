#include <tenon/apps/common/customisation.h>
#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/quadruped/limit_figures.h>

#include <fmt/core.h>

namespace tenon::apps {

std::vector<SignalLimits> DriveLimits(const QuadrupedPlant& plant) {
  std::vector<SignalLimits> limits;
  if (FindCurrent(plant.joint_torque) == nullptr || !KnowsLimits<QuadrupedPlantParams>(plant)) return limits;
  const std::vector<Element> joints = Current(plant.joint_torque).elements();
  for (int i = 0; i < kNumJoints; ++i) {
    const JointDescription& joint = ParamsOf(plant).robot.joint(i);
    const std::string& name = joints[static_cast<std::size_t>(i)].name;
    limits.push_back({fmt::format("{}.{}", SignalName(plant.joint_torque), name),
                      {.low = -joint.torque_limit, .high = joint.torque_limit}});
    limits.push_back({fmt::format("{}.{}", SignalName(plant.state, &LeggedState::qd), name),
                      {.low = -joint.speed_limit, .high = joint.speed_limit}});
  }
  return limits;
}

namespace {

AddedShapes ShapesAddedTo(const QuadrupedPlant& plant) {
  const QuadrupedPlant& shipped = CurrentAs(plant);
  const QuadrupedPlantParams& params = shipped.params;
  return AddedShapes::Of(plant,
                         MakeQuadrupedGeometry(shipped.bare_robot, params.payload, params.terrain).size());
}

constexpr double kRounding = 1e-9;  // tolerance, relative to the torque limit of a drive

const char* NameOf(int leg) {
  return leg < 0 ? "trunk" : kLegNames[static_cast<std::size_t>(leg)];
}

}  // namespace

std::vector<const Source*> LimitFigures::Signals(const QuadrupedPlant& plant) {
  std::vector<const Source*> signals{&plant.state, &plant.joint_torque, &plant.foot_depths};
  if (!ShapesAddedTo(plant).empty()) signals.push_back(&plant.geometry);
  return Present(signals);
}

QuadrupedClearance MakeClearance(const QuadrupedPlant& plant) {
  const QuadrupedPlant& shipped = CurrentAs(plant);
  const QuadrupedPlantParams& params = ParamsOf(plant);
  return {&params == &shipped.params ? shipped.bare_robot : params.robot, params.terrain};
}

LimitFigures::LimitFigures(const QuadrupedPlant& plant)
    : plant_(plant),
      known_(KnowsLimits<QuadrupedPlantParams>(plant)),
      robot_(ParamsOf(plant).robot),
      clearance_(MakeClearance(plant)),
      terrain_(ParamsOf(plant).terrain),
      added_(ShapesAddedTo(plant)),
      foot_limit_(std::max(kPressedIn, kPressedRatio * robot_.foot_radius)) {}

void LimitFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  state_.Begin(names, &plant_.state);
  torque_.Begin(names, FindCurrent(plant_.joint_torque));
  added_.Begin(names, plant_.geometry);
  depth_.Begin(names, FindCurrent(plant_.foot_depths));
}

void LimitFigures::Row(std::span<const double> row) {
  if (!known_) return;
  const LeggedState x = state_.In(row);
  if (torque_) DriveRow(row[0], torque_.In(row), x.qd);
  if (depth_) FootRow(row[0], depth_.In(row));
  ClearanceRow(row[0], x);
  added_.Visit(row, [&](const std::string& name, const Vec<3>& p_W, double radius) {
    const Terrain::Surface ground = terrain_.At(p_W[0], p_W[1]);
    const double height = (p_W[2] - ground.height) * ground.normal_W[2] - radius;
    added_heights_.Add(height);
    if (height < -kPressedIn)
      breaches_.Add(row[0], "a body on the robot went into the ground",
                    fmt::format("{} by {:.3g} m, more than {} m", name, -height, kPressedIn));
  });
}

void LimitFigures::DriveRow(double time, const Vec<12>& torques, const Vec<12>& speeds) {
  for (int j = 0; j < kNumJoints; ++j) {
    const JointDescription& joint = robot_.joint(j);
    const double torque = torques[j], speed = speeds[j];
    const double possible = DriveTorque(torque, speed, joint, robot_.drive);
    // An excess within rounding is set to zero, so that figure and verdict agree.
    double excess = std::abs(torque - possible);
    if (excess <= kRounding * joint.torque_limit) excess = 0;
    torques_.Add(std::abs(torque));
    speeds_.Add(std::abs(speed));
    excesses_.Add(excess);
    if (excess == 0) continue;
    const auto [given, limit] = Beside(torque, possible);
    breaches_.Add(time, "a drive exceeded its torque-speed line",
                  fmt::format("{} gave {} N m at {:.3g} rad/s, where its limit is {} N m", joint.name, given,
                              speed, limit));
  }
}

void LimitFigures::FootRow(double time, const Vec<4>& depths) {
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const double depth = depths[leg];
    if (depth > 0) depths_.Add(depth);
    if (depth <= foot_limit_) continue;
    const auto [deep, limit] = Beside(depth, foot_limit_);
    breaches_.Add(time, "a foot went into the ground",
                  fmt::format("{} by {} m, more than {} m", NameOf(leg), deep, limit));
  }
}

void LimitFigures::ClearanceRow(double time, const LeggedState& x) {
  const auto [legs, trunk, ground] = clearance_.At(x);
  legs_.Add(legs.distance);
  trunk_.Add(trunk.distance);
  ground_.Add(ground.distance);
  const auto check = [&](const QuadrupedClearances::Gap& gap, const char* kind) {
    if (gap.distance >= -kPressedIn) return;
    const std::string other = gap.other < 0 ? "" : std::string(" and ") + NameOf(gap.other);
    const auto [deep, limit] = Beside(-gap.distance, kPressedIn);
    breaches_.Add(time, kind,
                  fmt::format("{}{} by {} m, more than {} m", NameOf(gap.leg), other, deep, limit));
  };
  check(legs, "two legs collided");
  check(trunk, "a leg went into the trunk");
  check(ground, "trunk, hip or knee went into the ground");
}

void LimitFigures::AddTo(Summary& summary) const {
  if (!known_) return;
  double strongest = 0;
  for (int i = 0; i < kNumJoints; ++i) strongest = std::max(strongest, robot_.joint(i).torque_limit);
  summary.Set("torque_max_N_m", torques_.max(), {.high = strongest});
  summary.Set("joint_speed_max_rad_per_s", speeds_.max());  // no limit: external forces may exceed it
  summary.Set("torque_beyond_drive_max_N_m", excesses_.max(), {.high = 0});
  summary.Set("foot_depth_max_m", depths_.max(), {.high = foot_limit_});
  summary.Set("leg_clearance_min_m", legs_.min(), {.low = -kPressedIn});
  summary.Set("trunk_clearance_min_m", trunk_.min(), {.low = -kPressedIn});
  summary.Set("ground_clearance_min_m", ground_.min(), {.low = -kPressedIn});
  if (!added_.empty()) summary.Set("added_clearance_min_m", added_heights_.min(), {.low = -kPressedIn});
  breaches_.AddTo(summary);
}

std::vector<const Source*> StandFigures::Signals(const QuadrupedStand& loop) {
  const QuadrupedWorld& world = loop.world;
  return Present<Source>({&world.plant.state, &world.plant.joint_torque, &world.plant.foot_forces,
                          &world.plant.energy, &world.encoders.joints, &world.torque_sensor.measured,
                          &world.foot_sensor.measured, &world.imu.measurement});
}

void StandFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  state_.Begin(names, &world_.plant.state);
  force_ = Columns(names, world_.plant.foot_forces);
}

void StandFigures::Row(std::span<const double> row) {
  const LeggedState state = state_.In(row);
  height_end_ = state.p_WB[2];
  height_.Add(*height_end_);
  if (!start_) start_ = state.p_WB.head<2>();
  drift_ = std::hypot(state.p_WB[0] - (*start_)[0], state.p_WB[1] - (*start_)[1]);
  const double x = state.q_WB[1], y = state.q_WB[2];
  tilt_.Add(std::acos(std::clamp(1 - 2 * (x * x + y * y), -1.0, 1.0)));
  for (std::size_t i = 0; i < force_.size(); i += 3) {
    const double force = std::hypot(row[force_[i]], row[force_[i + 1]], row[force_[i + 2]]);
    if (force > 0) load_.Add(force);
  }
}

void StandFigures::AddTo(Summary& summary) const {
  summary.Set("height_min_m", height_.min());
  summary.Set("height_end_m", height_end_);
  summary.Set("drift_m", drift_);
  summary.Set("tilt_max_rad", tilt_.max());
  summary.Set("foot_force_max_N", load_.max());
  summary.SetFell(world_.monitor.fall);
  summary.SetFollowed(std::nullopt);
}

}  // namespace tenon::apps
