#include <tenon/apps/cdpr/cdpr_figures.h>
#include <tenon/apps/common/customisation.h>
#include <tenon/apps/common/figure_text.h>
#include <tenon/controllers/optimization/infinity.h>

#include <fmt/core.h>

#include <numbers>

namespace tenon::apps {
namespace {

constexpr double kSettled = 0.02;  // threshold of the thesis [m]
constexpr double kTaken = 3;       // time after which the platform has settled under a load [s]

double Length(const Vec<3>& v) {
  return std::hypot(v[0], v[1], v[2]);
}

}  // namespace

std::vector<const Source*> CdprFigures::Signals(const CdprLoop& loop) {
  const CdprPlant& plant = loop.world.plant;
  return Present<Source>({&plant.platform, &plant.euler, &plant.acceleration, &plant.cables, &loop.command,
                          &loop.reference.reference, &loop.world.payload.payload});
}

void CdprFigures::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  const CdprPlant& plant = loop_.world.plant;
  const OutputPort<CdprReference>& reference = loop_.reference.reference;
  platform_.Begin(names, &plant.platform);
  euler_.Begin(names, &plant.euler);
  acceleration_.Begin(names, &plant.acceleration);
  tensions_ = Columns(names, plant.cables, &CableSignals::tension);
  commands_ = Columns(names, loop_.command);
  ref_position_.Begin(names, &reference, &CdprReference::position);
  ref_euler_.Begin(names, &reference, &CdprReference::euler);
}

void CdprFigures::Row(std::span<const double> row) {
  for (const std::size_t column : tensions_) tension_.Add(row[column]);
  for (const std::size_t column : commands_) command_.Add(row[column]);
  const Vec<3> euler = euler_.In(row), turn = euler - ref_euler_.In(row);
  const Vec<3> offset = platform_.In(row).p_WB - ref_position_.In(row);
  oscillation_.Add(Length(turn));
  const double error = Length(offset);
  error_.Add(error);
  path_.Add(row[0], error, turn[2]);
  if (row[0] >= loaded_from_ + kTaken && row[0] < settle_from_) {
    loaded_error_.Add(error);
    for (int i = 0; i < 3; ++i) loaded_euler_[static_cast<std::size_t>(i)].Add(euler[i]);
  }
  accelerations_.Add(Length(acceleration_.In(row).a_W));

  const double dt = row[0] - last_time_;
  if (!last_tension_.empty() && dt > 0) {
    for (std::size_t i = 0; i < tensions_.size(); ++i)
      tension_rate_.Add((row[tensions_[i]] - last_tension_[i]) / dt);
  }
  last_time_ = row[0];
  last_tension_.resize(tensions_.size());
  for (std::size_t i = 0; i < tensions_.size(); ++i) last_tension_[i] = row[tensions_[i]];

  if (row[0] < settle_from_) return;
  if (settle_from_ > loaded_from_) release_error_.Add(error);
  const bool inside = std::abs(offset[0]) <= kSettled && std::abs(offset[1]) <= kSettled;
  if (!inside) settled_since_.reset();
  if (inside && !settled_since_) settled_since_ = row[0] - settle_from_;
}

std::optional<double> CdprFigures::LoadedSwing() const {
  double variance = 0;
  for (const Tally& angle : loaded_euler_) {
    if (!angle.rms()) return std::nullopt;
    variance += std::max(0.0, std::pow(*angle.rms(), 2) - std::pow(*angle.mean(), 2));
  }
  return std::sqrt(variance);
}

void CdprFigures::AddTo(Summary& summary) const {
  summary.Set("tension_min_N", tension_.min());
  summary.Set("tension_max_N", tension_.max());
  summary.Set("command_min_N", command_.min());
  summary.Set("command_max_N", command_.max());
  summary.Set("tension_rate_rms_N_per_s", tension_rate_.rms());
  summary.Set("euler_oscillation_rms_rad", oscillation_.rms());
  summary.Set("acceleration_rms_m_per_s2", accelerations_.rms());
  summary.Set("tracking_error_rms_m", error_.rms());
  summary.Set("loaded_error_rms_m", loaded_error_.rms());
  summary.Set("loaded_swing_rms_rad", LoadedSwing());
  summary.Set("settling_time_s", settled_since_);
  summary.Set("release_peak_m", release_error_.max());
}

namespace {

constexpr double kQuarterTurn = std::numbers::pi / 2;

AddedShapes ShapesAddedTo(const CdprPlant& plant) {
  return AddedShapes::Of(plant, MakeCdprGeometry(CurrentAs(plant).params.robot).size());
}

bool Sags(const CdprDescription& robot) {
  return robot.cable.mass_per_length > 0;
}

}  // namespace

std::vector<const Source*> CdprLimits::Signals(const CdprLoop& loop) {
  std::vector<const Source*> signals{&loop.world.plant.platform, &loop.world.plant.euler,
                                     &loop.world.plant.cables, &loop.reference.reference,
                                     &loop.world.payload.payload};
  if (loop.world.hanging_load != nullptr) signals.push_back(&loop.world.hanging_load->load);
  if (Sags(RobotOf(loop.world.plant)) || !ShapesAddedTo(loop.world.plant).empty())
    signals.push_back(&loop.world.plant.geometry);
  return Present(signals);
}

CdprLimits::CdprLimits(const CdprLoop& loop, double cable_diameter)
    : loop_(loop),
      known_(KnowsLimits<CdprPlantParams>(loop.world.plant)),
      robot_(RobotOf(loop.world.plant)),
      anchors_(robot_),
      added_(ShapesAddedTo(loop.world.plant)),
      cable_diameter_(cable_diameter),
      box_(PlatformBox(robot_)),
      interference_(robot_) {}

void CdprLimits::Begin(const std::vector<std::string>& names, const std::vector<std::string>&) {
  const CdprPlant& plant = loop_.world.plant;
  platform_.Begin(names, &plant.platform);
  euler_.Begin(names, &plant.euler);
  reference_.Begin(names, &loop_.reference.reference, &CdprReference::euler);
  tension_ = Columns(names, plant.cables, &CableSignals::tension);
  payload_.Begin(names, &loop_.world.payload.payload);
  if (const HangingLoad* hanging = loop_.world.hanging_load) load_.Begin(names, &hanging->load);
  added_.Begin(names, plant.geometry);
  if (!Sags(robot_)) return;
  const Geometry shapes = MakeCdprGeometry(robot_);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (shapes[i].role != ShapeRole::kLine) continue;
    pieces_.push_back(
        {Columns(names, plant.geometry, i, &Shape::p_W)[2], Column(names, plant.geometry, i, &Shape::value)});
  }
}

void CdprLimits::Row(std::span<const double> row) {
  if (!known_) return;
  const PlatformState platform = platform_.In(row);
  const Eigen::Vector3d& p_WB = platform.p_WB;
  const Eigen::Matrix3d R_WB = platform.R_WB();
  CalcCableKinematics(robot_, p_WB, R_WB, &all_, anchors_, row[0]);
  DistanceRow(row, p_WB, R_WB);
  PlatformRow(row, R_WB);
  FloorRow(row, p_WB, R_WB);

  started_ = true;

  const double turn =
      std::abs(std::remainder(euler_.In(row)[2] - reference_.In(row)[2], 2 * std::numbers::pi));
  turns_.Add(turn);
  if (turn <= kQuarterTurn) return;
  const auto [turned, limit] = Beside(turn, kQuarterTurn);
  breaches_.Add(row[0], "the platform turned beyond the reach of its cables",
                fmt::format("by {} rad from its reference, more than {} rad", turned, limit));
}

void CdprLimits::DistanceRow(std::span<const double> row, const Eigen::Vector3d& p_WB,
                             const Eigen::Matrix3d& R_WB) {
  if (!started_) clearance_ = CdprClearance(robot_, 0, cable_diameter_, all_);
  const auto slack = [&](int cable) {
    return cable >= 0 && row[tension_[static_cast<std::size_t>(cable)]] <= 0;
  };
  const auto exit_W = [&](int i) { return all_.exit_W.col(i); };
  clearance_.ForEach(p_WB, R_WB, exit_W, [&](int a, int b, const PoseDistance& distance) {
    if (slack(a) || slack(b)) return;
    (b < 0 ? clearances_ : distances_).Add(distance.value);
    if (distance.value >= distance.kept) return;
    if (b < 0) {
      const std::string name = a < 0 ? "the platform" : fmt::format("cable {}", a);
      breaches_.Add(row[0], "the robot ran into an obstacle",
                    fmt::format("{} by {:.3g} m", name, -distance.value));
      return;
    }
    const auto [apart, limit] = Beside(distance.value, cable_diameter_);
    breaches_.Add(row[0], "two cables touched",
                  fmt::format("the axes of {} and {} were {} m apart, less than {} m", a, b, apart, limit));
  });
}

void CdprLimits::PlatformRow(std::span<const double> row, const Eigen::Matrix3d& R_WB) {
  double sine = kInfinity;
  for (int i = 0; i < robot_.num_cables(); ++i)
    if (row[tension_[static_cast<std::size_t>(i)]] > 0)
      sine = std::min(sine, interference_.PlatformSine(i, all_, R_WB));
  if (sine == kInfinity) return;
  if (!started_) open_frame_ = sine < 0;
  if (open_frame_) return;
  const double angle = std::asin(std::clamp(sine, -1.0, 1.0));
  angles_.Add(angle);
  if (angle < 0)
    breaches_.Add(row[0], "a cable ran through the platform",
                  fmt::format("{:.3g} rad below its surface", -angle));
}

void CdprLimits::FloorRow(std::span<const double> row, const Eigen::Vector3d& p_WB,
                          const Eigen::Matrix3d& R_WB) {
  if (robot_.on_table) return;
  double lowest = LowestCorner(box_, p_WB, R_WB);
  const char* name = "the platform";
  const auto add = [&](double height, const char* of) {
    if (height >= lowest) return;
    lowest = height;
    name = of;
  };
  if (const Payload payload = payload_.In(row); payload.mass > 0)
    add(p_WB[2] + R_WB.row(2).dot(payload.p_B), "the payload");
  if (load_) add(load_.In(row).p_W[2], "the hanging load");
  for (const auto& [height, tension] : pieces_)
    if (row[tension] > 0) add(row[height], "a cable");
  added_.Visit(row, [&](const std::string& of, const Vec<3>& p_W, double radius) {
    add(p_W[2] - radius, of.c_str());
  });
  lowest -= robot_.floor;
  heights_.Add(lowest);
  if (lowest < 0)
    breaches_.Add(row[0], "platform, load or cables went through the floor",
                  fmt::format("{} by {:.3g} m", name, -lowest));
}

void CdprLimits::AddTo(Summary& summary) const {
  if (!known_) return;
  summary.Set("cable_distance_min_m", distances_.min(), {.low = cable_diameter_});
  summary.Set("cable_platform_angle_min_rad", angles_.min(), {.low = 0});
  if (!robot_.obstacles.empty()) summary.Set("clearance_min_m", clearances_.min(), {.low = 0});
  summary.Set("floor_clearance_min_m", heights_.min(), {.low = 0});
  summary.Set("turn_max_rad", turns_.max(), {.high = kQuarterTurn});
  breaches_.AddTo(summary);
}

}  // namespace tenon::apps
