#include <tenon/apps/common/customisation.h>
#include <tenon/apps/quadruped/limit_figures.h>
#include <tenon/apps/quadruped/walk_figures.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon::apps {

void CheckJudged(double from, double end, bool cut) {
  if (from <= end) return;
  const std::string what =
      fmt::format("the run ends at {:.4g} s, before walk.judged_from_s = {:.4g} s", end, from);
  if (!cut) throw KeyError("walk.judged_from_s", what + ": lower walk.judged_from_s, or lengthen the walk");
  Say(fmt::format("warning: {}: its figures are null\n", what));
}

namespace {

/// Whether the plant that stands in the diagram may exert an added wrench.
bool IsExtended(const QuadrupedPlant& plant) {
  const QuadrupedPlant& shipped = CurrentAs(plant);
  return CurrentBlock(plant) != &shipped || shipped.params.extend;
}

/// Whether the planner resets the reference to the robot or moves it off the path, so that errors against it
/// tell nothing about the path.
bool LeavesPath(const QuadrupedWalk& loop) {
  const ComPlanner& planner = loop.locomotion.com_planner;
  const ComReference reference = planner.params.reference;
  return reference != ComReference::kPendulum && reference != ComReference::kZmpSpline &&
         FindCurrent(planner.path) != nullptr;
}

double Yaw(const Vec<4>& q_WB) {
  const Eigen::Matrix3d R = RotationFromQuaternion(q_WB);
  return std::atan2(R(1, 0), R(0, 0));
}

}  // namespace

const OutputPort<Geometry>* AddLegErrors(DiagramBuilder& builder, const QuadrupedWalk& loop) {
  auto& errors = builder.Add<LegErrors>("leg_errors", LegErrorsParams{.robot = loop.errors.params.robot});
  builder.Connect(loop.world.state, errors.state);
  builder.Connect(loop.world.external_torque, errors.external_torque);
  builder.Connect(loop.observer.leg_forces, errors.leg_forces);
  builder.Connect(loop.locomotion.schedule, errors.schedule);
  builder.Connect(loop.locomotion.feet, errors.feet);
  // A block in the place of a shipped one may lack these ports.
  const auto& external = loop.world.disturbances.forces;
  if (FindCurrent(external) != nullptr) builder.Connect(external, errors.external);
  const auto& footholds = loop.locomotion.swing_planner.footholds;
  if (FindCurrent(footholds) == nullptr) return nullptr;
  builder.Connect(footholds, errors.footholds);
  return &errors.geometry;
}

WalkFigures::WalkFigures(const QuadrupedWalk& loop, double from, bool observes, const PathVerdict& path)
    : loop_(loop),
      from_(from),
      observes_(observes || CurrentBlock(loop.observer) != &loop.observer),
      path_(path),
      estimate_(loop) {
  if (KnowsLimits<QuadrupedPlantParams>(loop.world.plant))
    terrain_.emplace(ParamsOf(loop.world.plant).terrain);
}

std::vector<const Source*> WalkFigures::Signals(const QuadrupedWalk& loop) {
  std::vector<const Source*> signals{&loop.world.plant.state,
                                     &loop.world.plant.joint_torque,
                                     &loop.world.plant.foot_forces,
                                     &loop.world.plant.foot_slips,
                                     &loop.world.plant.external_wrench,
                                     &loop.world.plant.external_torque,
                                     &loop.observer.wrench,
                                     &loop.observer.leg_forces,
                                     &loop.locomotion.body,
                                     &loop.locomotion.schedule,
                                     &loop.errors.errors,
                                     &loop.errors.external_foot_forces};
  if (HasElements(loop.world.plant.added_speeds)) {
    signals.push_back(&loop.world.plant.added_positions);
    signals.push_back(&loop.world.plant.added_speeds);
  }
  if (loop.locomotion.mpc_age != nullptr) signals.push_back(loop.locomotion.mpc_age);
  if (loop.ropes) {
    signals.push_back(&loop.ropes->tension);
    signals.push_back(&loop.tensions->wrench);
  }
  return Present(WithOptions(std::move(signals), loop));
}

std::vector<const Source*> WalkFigures::WithOptions(std::vector<const Source*> signals,
                                                    const QuadrupedWalk& loop) {
  if (IsExtended(loop.world.plant)) signals.push_back(&loop.world.plant.added_wrench);
  if (loop.deployment) signals.insert(signals.end(), {&loop.deployment->status, &loop.drives->torque});
  if (loop.estimator) {
    signals.push_back(&loop.estimator->estimate);
    signals.push_back(&loop.errors.path);
  }
  return signals;
}

std::vector<const Source*> WalkFigures::WithSolvers(std::vector<const Source*> signals,
                                                    const QuadrupedWalk& loop) {
  if (const Source* solves = Solves(loop)) signals.push_back(solves);
  if (const Source* solves = MpcSolves(loop)) signals.push_back(solves);
  if (FindCurrent(loop.walk.command) != nullptr) signals.push_back(&loop.walk.command);
  if (LeavesPath(loop)) signals.push_back(&loop.locomotion.com_planner.path);
  return signals;
}

void WalkFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  const QuadrupedPlant& plant = loop_.world.plant;
  errors_.Begin(names, FindCurrent(loop_.errors.errors));
  if (LeavesPath(loop_)) commanded_path_.Begin(names, FindCurrent(loop_.locomotion.com_planner.path));
  external_.Begin(names, FindCurrent(plant.external_wrench));
  if (IsExtended(plant) && loop_.known_additions == nullptr)
    added_.Begin(names, FindCurrent(plant.added_wrench));
  estimated_.Begin(names, &loop_.observer.wrench);
  if (loop_.tensions) ropes_.Begin(names, &loop_.tensions->wrench);
  slip_ = Columns(names, FindCurrent(plant.foot_slips));
  touch_ = Columns(names, FindCurrent(plant.foot_forces));
  torque_.Begin(names, FindCurrent(plant.joint_torque));
  state_.Begin(names, &plant.state);
  body_.Begin(names, &loop_.locomotion.body);
  command_.Begin(names, FindCurrent(loop_.walk.command));
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    contact_[leg] = Column(names, loop_.locomotion.schedule, &ContactSchedule::legs, leg, &LegContact::state);
  qp_.Begin(names, Solves(loop_), &WholeBodyDiagnostics::failures);
  mpc_.Begin(names, MpcSolves(loop_), &CentroidalMpcDiagnostics::failures);
  estimate_.Begin(names);
}

void WalkFigures::Row(std::span<const double> row) {
  const LeggedState x = state_.In(row);
  const WalkingErrors errors = errors_ ? errors_.In(row) : WalkingErrors();
  if (errors_ && commanded_path_) {
    const PlanarPath commanded = commanded_path_.In(row);
    const double deviation = std::hypot(errors.com_position[0] - commanded.position_W[0],
                                        errors.com_position[1] - commanded.position_W[1]);
    path_.Add(row[0], deviation, Yaw(x.q_WB) - commanded.yaw);
  } else if (errors_) {
    path_.Add(row[0], std::hypot(errors.com[0], errors.com[1]), Yaw(x.q_WB) - Yaw(body_.In(row).q_WB));
  }
  if (row[0] < from_) return;
  if (errors_) com_errors_.Add(std::hypot(errors.com[0], errors.com[1], errors.com[2]));
  if (observes_ && external_) {
    const Vec<3> estimated = estimated_.In(row).force_W;
    Vec<3> error = estimated - external_.In(row).force_W;
    if (added_) error -= added_.In(row).force_W;
    if (ropes_) error += ropes_.In(row).force_W;
    for (int i = 0; i < 3; ++i) estimates_[static_cast<std::size_t>(i)].Add(estimated[i]);
    estimate_errors_.Add(std::hypot(error[0], error[1], error[2]));
  }
  qp_.Row(row);
  mpc_.Row(row);
  end_ = {x.p_WB[0], x.p_WB[1]};
  if (!begin_) begin_ = end_;
  if (command_ && time_ > 0) {
    const WalkCommand command = command_.In(row);
    const double dt = row[0] - time_;
    commanded_yaw_ += dt * command.yaw_rate;
    commanded_ += dt * (Eigen::Rotation2D(commanded_yaw_) * Vec<2>(command.forward, command.left));
  }
  if (terrain_)
    climb_.Add(terrain_->At(end_[0], end_[1]).height - terrain_->At((*begin_)[0], (*begin_)[1]).height);
  if (!touch_.empty())
    flight_.Add(std::ranges::all_of(touch_, [&](std::size_t column) { return row[column] == 0; }) ? 1 : 0);
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) LegRow(row, leg, errors);
  if (torque_) JointRow(row[0], torque_.In(row), x.qd);
  estimate_.Row(row);
  time_ = row[0];
}

void WalkFigures::LegRow(std::span<const double> row, std::size_t leg, const WalkingErrors& errors) {
  LegFigures& figures = legs_[leg];
  const bool stance = row[contact_[leg]] == static_cast<double>(ContactState::kStance);
  if (stance && !figures.stance) {
    figures.touchdown = row[0];
    figures.slip = {};
  }
  if (!stance) {
    figures.waiting.clear();
    if (errors_ && row[contact_[leg]] == static_cast<double>(ContactState::kSwing))
      figures.errors.Add(errors.foot[static_cast<int>(leg)]);
  }
  figures.stance = stance;
  if (!stance || row[0] < figures.touchdown + kEdge) return;

  if (!slip_.empty()) {
    for (std::size_t i = 0; i < 3; ++i) figures.slip[i] += (row[0] - time_) * row[slip_[3 * leg + i]];
    figures.slips.Add(std::hypot(figures.slip[0], figures.slip[1], figures.slip[2]));
  }
  if (!errors_) return;
  figures.waiting.push_back({row[0], errors.ground_force[static_cast<int>(leg)]});
  while (figures.waiting.front().time < row[0] - kEdge) {
    force_errors_.Add(figures.waiting.front().error);
    figures.waiting.pop_front();
  }
}

void WalkFigures::JointRow(double time, const Vec<12>& torque, const Vec<12>& speed) {
  if (const double dt = time - time_; last_torque_ && dt > 0) {
    work_ += dt * torque.cwiseProduct(speed).cwiseAbs().sum();
    for (const double change : torque - *last_torque_) torque_rates_.Add(change / dt);
  }
  last_torque_ = torque;
}

void WalkFigures::AddTo(Summary& summary) const {
  const auto largest_by_leg = [&](Tally LegFigures::*figure) {
    std::vector<std::pair<std::string, std::optional<double>>> values;
    for (std::size_t leg = 0; leg < kNumLegs; ++leg)
      values.emplace_back(kLegNames[leg], (legs_[leg].*figure).max());
    return values;
  };
  summary.SetFell(loop_.world.monitor.fall);
  std::optional<double> distance;
  if (begin_) distance = std::hypot(end_[0] - (*begin_)[0], end_[1] - (*begin_)[1]);
  summary.Set("judged_from_s", from_);
  summary.Set("com_error_max_m", com_errors_.max());
  summary.Set("com_error_rms_m", com_errors_.rms());
  summary.Set("foot_error_max_m", largest_by_leg(&LegFigures::errors));
  if (!estimate_.AddPathTo(summary)) {  // the controller reads the true state: there is no drift
    summary.Set("path_error_max_m", com_errors_.max());
    summary.Set("path_foot_error_max_m", largest_by_leg(&LegFigures::errors));
  }
  summary.Set("grf_error_mean_N", force_errors_.mean());
  summary.Set("force_estimate_mean_N",
              {{"x", estimates_[0].mean()}, {"y", estimates_[1].mean()}, {"z", estimates_[2].mean()}});
  summary.Set("force_estimate_error_rms_N", estimate_errors_.rms());
  summary.Set("slip_max_m", largest_by_leg(&LegFigures::slips));
  summary.Set("joint_work_J", last_torque_ ? std::optional(work_) : std::nullopt);
  summary.Set("torque_rate_rms_Nm_per_s", torque_rates_.rms());
  summary.Set("distance_m", distance);
  summary.Set("climb_m", climb_.max());
  summary.Set("flight_ratio", flight_.mean());
  path_.AddTo(summary);
  qp_.AddTo(summary, "qp", "qp_failures");
  if (loop_.locomotion.mpc) mpc_.AddTo(summary, "mpc", "mpc_failures");
  estimate_.AddTo(summary);
}

void StateErrors::Add(const LeggedState& estimated, const LeggedState& truth) {
  velocity_.Add((estimated.v_W - truth.v_W).norm());
  // The vertical in the axes of the trunk, true and estimated.
  const Vec<3> up = truth.R_WB().row(2), estimated_up = estimated.R_WB().row(2);
  tilt_.Add(std::atan2(up.cross(estimated_up).norm(), up.dot(estimated_up)));
  const Vec<3> distance = estimated.p_WB - truth.p_WB;
  position_end_ = distance.norm();
  drift.Add(distance.norm());
  height_drift.Add(std::abs(distance[2]));
}

void StateErrors::AddTo(Summary& summary, const std::string& prefix) const {
  summary.Set(prefix + "velocity_estimate_error_rms_m_per_s", velocity_.rms());
  summary.Set(prefix + "velocity_estimate_error_max_m_per_s", velocity_.max());
  summary.Set(prefix + "tilt_estimate_error_rms_rad", tilt_.rms());
  summary.Set(prefix + "tilt_estimate_error_max_rad", tilt_.max());
  summary.Set(prefix + "position_estimate_error_end_m", position_end_);
}

void EstimateFigures::Begin(const std::vector<std::string>& names) {
  if (loop_.estimator != nullptr)
    estimated_.Begin(names, FindCurrent(loop_.estimator->estimate), &LeggedEstimate::state);
  if (!estimated_) return;
  true_.Begin(names, &loop_.world.plant.state);
  path_.Begin(names, FindCurrent(loop_.errors.path));
}

void EstimateFigures::Row(std::span<const double> row) {
  if (!estimated_) return;
  errors_.Add(estimated_.In(row), true_.In(row));
  if (!path_) return;
  const PathErrors path = path_.In(row);
  path_errors_.Add(path.com.norm());
  for (int leg = 0; leg < kNumLegs; ++leg)  // 0 marks a foot in stance
    if (path.foot[leg] > 0) path_foot_errors_[static_cast<std::size_t>(leg)].Add(path.foot[leg]);
}

void EstimateFigures::AddTo(Summary& summary) const {
  if (estimated_) errors_.AddTo(summary);
}

bool EstimateFigures::AddPathTo(Summary& summary) const {
  if (!estimated_) return false;
  std::vector<std::pair<std::string, std::optional<double>>> feet;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    feet.emplace_back(kLegNames[leg], path_foot_errors_[leg].max());
  summary.Set("path_error_max_m", path_errors_.max());
  summary.Set("path_foot_error_max_m", feet);
  summary.Set("drift_m", errors_.drift.max());
  summary.Set("height_drift_m", errors_.height_drift.max());
  return true;
}

namespace {

/// Compares the estimate of a constant force on a foot with the force.
class FootStepFigures final : public LogSink {
 public:
  FootStepFigures(const OutputPort<LegForceEstimate>& estimate, int leg, const Vec<3>& force_W, double start)
      : estimate_(estimate), leg_(leg), force_W_(force_W), start_(start) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override {
    forces_.Begin(names, &estimate_, &LegForceEstimate::foot_force);
  }
  void Row(std::span<const double> row) override {
    if (row[0] < start_) return;
    const double share = forces_.In(row)[leg_].dot(force_W_) / force_W_.squaredNorm();
    shares_.Add(share);
    const bool settled = std::abs(share - 1) <= 0.02;
    if (!settled) settled_since_.reset();
    if (settled && !settled_since_) settled_since_ = row[0] - start_;
  }
  void AddTo(Summary& summary) const {
    summary.Set("force_settling_time_s", settled_since_);
    const std::optional<double> peak = shares_.max();
    summary.Set("force_overshoot_ratio", peak ? std::optional(std::max(0.0, *peak - 1)) : peak);
  }

 private:
  const OutputPort<LegForceEstimate>& estimate_;
  int leg_;
  Vec<3> force_W_;  // [N]
  double start_;    // [s]
  Logged<FootForces> forces_;
  Tally shares_;  // of the force that the estimate shows
  std::optional<double> settled_since_;
};

}  // namespace

void JudgeFootStep(const QuadrupedScenario& scenario, double duration, const QuadrupedWalk& loop,
                   Outputs& outputs) {
  const auto* const estimate = FindCurrent(loop.observer.leg_forces);
  if (estimate == nullptr || scenario.forces.size() != 1 || scenario.scale_forces) return;
  const ForceScenario& force = scenario.forces[0];
  if (force.on == Part::kTrunk || force.height != 0 || force.frequency_rad_per_s != 0 ||
      force.start_s + force.duration_s < duration)
    return;
  const Vec<3> force_W = force.factor * (Eigen::AngleAxisd(force.turn_rad, Vec<3>::UnitZ()) * force.force_N);
  if (force_W.isZero(0)) return;
  const int leg = static_cast<int>(force.on) - static_cast<int>(Part::kFrontLeft);
  const auto sink = std::make_shared<FootStepFigures>(*estimate, leg, force_W, force.start_s);
  outputs.Judge(Hz(1000), {estimate}, sink, [sink](Summary& summary) { sink->AddTo(summary); });
}

}  // namespace tenon::apps
