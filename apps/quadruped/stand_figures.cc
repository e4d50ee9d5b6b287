#include <tenon/apps/quadruped/stand_figures.h>

namespace tenon::apps {

std::vector<const Source*> StandFigures::Signals(const QuadrupedStand& loop) {
  const QuadrupedWorld& world = loop.world;
  return Present<Source>({&world.plant.state, &world.plant.joint_torque, &world.plant.foot_forces,
                          &world.plant.energy, &world.encoders.joints, &world.torque_sensor.measured,
                          &world.foot_sensor.measured, &world.imu.measurement});
}

void StandFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  position_ = Columns(names, world_.plant.state, &LeggedState::p_WB);
  attitude_ = Columns(names, world_.plant.state, &LeggedState::q_WB);
  force_ = Columns(names, world_.plant.foot_forces);
}

void StandFigures::Row(std::span<const double> row) {
  height_end_ = row[position_[2]];
  height_.Add(*height_end_);
  if (start_.empty()) start_ = {row[position_[0]], row[position_[1]]};
  drift_ = std::hypot(row[position_[0]] - start_[0], row[position_[1]] - start_[1]);
  const double x = row[attitude_[1]], y = row[attitude_[2]];
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
