#include <tenon/apps/quadruped/stand_figures.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <tenon/apps/common/columns.h>

namespace tenon::apps {

std::vector<const Source*> StandFigures::Signals(const QuadrupedStand& loop) {
  const QuadrupedWorld& world = loop.world;
  return {&world.plant.state,          &world.plant.joint_torque, &world.plant.foot_forces,
          &world.plant.energy,         &world.encoders.joints,    &world.torque_sensor.measured,
          &world.foot_sensor.measured, &world.imu.measurement};
}

void StandFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  position_ = Columns(names, "loop.world.plant.state.p_WB");
  attitude_ = Columns(names, "loop.world.plant.state.q_WB");
  torque_ = Columns(names, "loop.world.plant.joint_torque");
  force_ = Columns(names, "loop.world.plant.foot_forces");
  height_min_ = std::numeric_limits<double>::infinity();
}

void StandFigures::Row(std::span<const double> row) {
  height_end_ = row[position_[2]];
  height_min_ = std::min(height_min_, height_end_);
  if (start_.empty()) start_ = {row[position_[0]], row[position_[1]]};
  drift_ = std::hypot(row[position_[0]] - start_[0], row[position_[1]] - start_[1]);
  const double x = row[attitude_[1]], y = row[attitude_[2]];
  tilt_max_ = std::max(tilt_max_, std::acos(std::clamp(1 - 2 * (x * x + y * y), -1.0, 1.0)));
  for (const std::size_t column : torque_) torque_max_ = std::max(torque_max_, std::abs(row[column]));
  for (std::size_t i = 0; i < force_.size(); i += 3)
    force_max_ = std::max(force_max_, std::hypot(row[force_[i]], row[force_[i + 1]], row[force_[i + 2]]));
}

void StandFigures::AddTo(Summary& summary) const {
  summary.Set("height_min_m", height_min());
  summary.Set("height_end_m", height_end());
  summary.Set("drift_m", drift());
  summary.Set("tilt_max_rad", tilt_max());
  summary.Set("torque_max_N_m", torque_max());
  summary.Set("foot_force_max_N", foot_force_max());
}

}  // namespace tenon::apps
