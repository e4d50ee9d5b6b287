#include <tenon/apps/common/customisation.h>
#include <tenon/apps/quadruped/limit_figures.h>
#include <tenon/apps/quadruped/walk_figures.h>
#include <tenon/diagrams/evaluation/tracking_error.h>

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

/// Whether the planner resets the reference to the robot, so that errors against it tell nothing about the
/// path.
bool IsReset(const QuadrupedWalk& loop) {
  const ComPlanner& planner = loop.locomotion.com_planner;
  return planner.params.reference == ComReference::kThesis && FindCurrent(planner.path) != nullptr;
}

double Yaw(std::span<const double> row, const std::vector<std::size_t>& attitude) {
  const Eigen::Matrix3d R = RotationFromQuaternion(VectorIn<4>(row, attitude));
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

std::vector<const Source*> WalkFigures::Judged(const QuadrupedWalk& loop) {
  return WithSolvers(Signals(loop), loop);
}

std::vector<const Source*> WalkFigures::WithSolvers(std::vector<const Source*> signals,
                                                    const QuadrupedWalk& loop) {
  if (const Source* solves = Solves(loop)) signals.push_back(solves);
  if (const Source* solves = MpcSolves(loop)) signals.push_back(solves);
  if (FindCurrent(loop.walk.command) != nullptr) signals.push_back(&loop.walk.command);
  if (IsReset(loop)) signals.push_back(&loop.locomotion.com_planner.path);
  return signals;
}

void WalkFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  const auto* errors = FindCurrent(loop_.errors.errors);
  com_ = Columns(names, errors, &WalkingErrors::com);
  foot_ = Columns(names, errors, &WalkingErrors::foot);
  ground_force_ = Columns(names, errors, &WalkingErrors::ground_force);
  if (IsReset(loop_)) {
    com_position_ = Columns(names, errors, &WalkingErrors::com_position);
    commanded_place_ =
        Columns(names, FindCurrent(loop_.locomotion.com_planner.path), &PlanarPath::position_W);
    commanded_heading_ = Column(names, FindCurrent(loop_.locomotion.com_planner.path), &PlanarPath::yaw);
  }
  const QuadrupedPlant& plant = loop_.world.plant;
  external_force_ = Columns(names, FindCurrent(plant.external_wrench), &WrenchEstimate::force_W);
  if (IsExtended(plant) && loop_.known_additions == nullptr)
    added_force_ = Columns(names, FindCurrent(plant.added_wrench), &WrenchEstimate::force_W);
  estimated_force_ = Columns(names, loop_.observer.wrench, &WrenchEstimate::force_W);
  if (loop_.tensions) rope_force_ = Columns(names, loop_.tensions->wrench, &WrenchEstimate::force_W);
  slip_ = Columns(names, FindCurrent(plant.foot_slips));
  touch_ = Columns(names, FindCurrent(plant.foot_forces));
  torque_ = Columns(names, FindCurrent(plant.joint_torque));
  speed_ = Columns(names, plant.state, &LeggedState::qd);
  position_ = Columns(names, plant.state, &LeggedState::p_WB);
  attitude_ = Columns(names, plant.state, &LeggedState::q_WB);
  told_attitude_ = Columns(names, loop_.locomotion.body, &BodyReference::q_WB);
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    contact_[leg] = Column(names, loop_.locomotion.schedule, &ContactSchedule::legs, leg, &LegContact::state);
  for (double WalkCommand::*velocity : {&WalkCommand::forward, &WalkCommand::left, &WalkCommand::yaw_rate})
    if (const auto column = Column(names, FindCurrent(loop_.walk.command), velocity))
      command_.push_back(*column);
  solve_time_ = Column(names, Solves(loop_), &WholeBodyDiagnostics::solve_time);
  failures_ = Column(names, Solves(loop_), &WholeBodyDiagnostics::failures);
  mpc_time_ = Column(names, MpcSolves(loop_), &CentroidalMpcDiagnostics::solve_time);
  mpc_failures_ = Column(names, MpcSolves(loop_), &CentroidalMpcDiagnostics::failures);
  estimate_.Begin(names);
}

void WalkFigures::Row(std::span<const double> row) {
  if (!com_.empty() && commanded_heading_) {
    const double deviation = std::hypot(row[com_position_[0]] - row[commanded_place_[0]],
                                        row[com_position_[1]] - row[commanded_place_[1]]);
    path_.Add(row[0], deviation, Yaw(row, attitude_) - row[*commanded_heading_]);
  } else if (!com_.empty()) {
    path_.Add(row[0], std::hypot(row[com_[0]], row[com_[1]]), Yaw(row, attitude_) - Yaw(row, told_attitude_));
  }
  if (row[0] < from_) return;
  const auto norm = [&](const std::vector<std::size_t>& columns) {
    return std::hypot(row[columns[0]], row[columns[1]], row[columns[2]]);
  };
  if (!com_.empty()) com_errors_.Add(norm(com_));
  if (observes_ && !external_force_.empty()) {
    std::array<double, 3> error{};
    for (std::size_t i = 0; i < 3; ++i) {
      estimates_[i].Add(row[estimated_force_[i]]);
      error[i] = row[estimated_force_[i]] - row[external_force_[i]];
      if (!added_force_.empty()) error[i] -= row[added_force_[i]];
      if (loop_.tensions) error[i] += row[rope_force_[i]];
    }
    estimate_errors_.Add(std::hypot(error[0], error[1], error[2]));
  }
  if (solve_time_) {
    solve_times_.Add(row[*solve_time_]);
    failure_count_ = row[*failures_];
  }
  if (mpc_time_) {
    mpc_times_.Add(row[*mpc_time_]);
    mpc_failure_count_ = row[*mpc_failures_];
  }
  end_ = {row[position_[0]], row[position_[1]]};
  if (!begin_) begin_ = end_;
  if (!command_.empty() && time_ > 0) {
    const double dt = row[0] - time_;
    commanded_yaw_ += dt * row[command_[2]];
    commanded_ += dt * (Eigen::Rotation2D(commanded_yaw_) * Vec<2>(row[command_[0]], row[command_[1]]));
  }
  if (terrain_)
    climb_.Add(terrain_->At(end_[0], end_[1]).height - terrain_->At((*begin_)[0], (*begin_)[1]).height);
  if (!touch_.empty())
    flight_.Add(std::ranges::all_of(touch_, [&](std::size_t column) { return row[column] == 0; }) ? 1 : 0);
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) LegRow(row, leg);
  if (!torque_.empty()) JointRow(row);
  estimate_.Row(row);
  time_ = row[0];
}

void WalkFigures::LegRow(std::span<const double> row, std::size_t leg) {
  LegFigures& figures = legs_[leg];
  const bool stance = row[contact_[leg]] == static_cast<double>(ContactState::kStance);
  if (stance && !figures.stance) {
    figures.touchdown = row[0];
    figures.slip = {};
  }
  if (!stance) {
    figures.waiting.clear();
    if (!foot_.empty() && row[contact_[leg]] == static_cast<double>(ContactState::kSwing))
      figures.errors.Add(row[foot_[leg]]);
  }
  figures.stance = stance;
  if (!stance || row[0] < figures.touchdown + kEdge) return;

  if (!slip_.empty()) {
    for (std::size_t i = 0; i < 3; ++i) figures.slip[i] += (row[0] - time_) * row[slip_[3 * leg + i]];
    figures.slips.Add(std::hypot(figures.slip[0], figures.slip[1], figures.slip[2]));
  }
  if (ground_force_.empty()) return;
  figures.waiting.push_back({row[0], row[ground_force_[leg]]});
  while (figures.waiting.front().time < row[0] - kEdge) {
    force_errors_.Add(figures.waiting.front().error);
    figures.waiting.pop_front();
  }
}

void WalkFigures::JointRow(std::span<const double> row) {
  const Vec<12> torque = VectorIn<12>(row, torque_), speed = VectorIn<12>(row, speed_);
  if (const double dt = row[0] - time_; last_torque_ && dt > 0) {
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
  summary.Set("qp_time_median_us", Microseconds(solve_times_.Quantile(0.5)));
  summary.Set("qp_time_p99_us", Microseconds(solve_times_.Quantile(0.99)));
  summary.Set("qp_failures", failure_count_);
  if (loop_.locomotion.mpc) {
    summary.Set("mpc_time_median_us", Microseconds(mpc_times_.Quantile(0.5)));
    summary.Set("mpc_time_p99_us", Microseconds(mpc_times_.Quantile(0.99)));
    summary.Set("mpc_failures", mpc_failure_count_);
  }
  estimate_.AddTo(summary);
}

}  // namespace tenon::apps
