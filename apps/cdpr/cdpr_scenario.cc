#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/controllers/cdpr/tension_distribution.h>
#include <tenon/diagrams/cdpr/cdpr_profile.h>
#include <tenon/plants/attached_bodies.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>
#include <fmt/format.h>

#include <numbers>

namespace tenon::apps {

void SetHardware(const YamlFile& what, CdprLoopParams& loop) {
  CdprHardware hardware = LoadResource("hardware/cdpr", what).Read<CdprHardware>();
  auto& [cables, pose, imu] = hardware.sensors;
  CdprHardwareParams& params = loop.hardware;
  hardware.winches.num_cables = loop.robot.num_cables();
  hardware.winches.rate = hardware.link.rate = loop.mpc ? loop.mpc->command_rate : loop.control_rate;
  hardware.link.initial = CableVector::Zero(loop.robot.num_cables());
  if (hardware.calculation.any() && !loop.mpc)
    throw ParameterError(
        "calculation has no effect without predictive control: choose a controller with an MPC, or remove "
        "it");
  params.calculation = hardware.calculation;
  if (hardware.winches.any()) params.winch_errors = hardware.winches;
  hardware.link.Validate();
  if (hardware.link.delay > 0) params.command_delay = hardware.link;
  params.cable_sensors = cables;
  if (cables) params.cable_sensors->num_cables = loop.robot.num_cables();
  loop.pose_sensor.position_offset = pose.position_offset;
  loop.pose_sensor.attitude_offset = pose.attitude_offset;
  params.pose_delay = pose.latency;
  imu.rate = loop.imu.rate;
  if (imu.any()) params.imu_errors = imu;
  params.imu_delay = imu.latency;
}

namespace {

void CheckWaypoints(const std::vector<WaypointScenario>& waypoints) {
  Demand(waypoints.size() >= 2, fmt::format("waypoints has {} entries: give two or more", waypoints.size()));
  const WaypointScenario& start = waypoints.front();
  Demand(!start.travel_s && !start.speed_m_per_s,
         "waypoints.0 is the start: remove its travel_s and speed_m_per_s");
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    const WaypointScenario& waypoint = waypoints[i];
    Demand(waypoint.travel_s.has_value() != waypoint.speed_m_per_s.has_value(),
           fmt::format("waypoints.{}: give either travel_s or speed_m_per_s, not {}", i,
                       waypoint.travel_s ? "both" : "neither"));
    Demand(
        waypoint.travel_s || waypoint.position_m != waypoints[i - 1].position_m,
        fmt::format("waypoints.{} has the position of waypoints.{}: give travel_s instead of speed_m_per_s, "
                    "or increase dwell_s of waypoints.{}",
                    i, i - 1, i - 1));
    Demand(!waypoint.attitude_rad || start.attitude_rad,
           fmt::format("waypoints.{} has attitude_rad, but waypoints.0 has none: add it to waypoints.0", i));
  }
}

}  // namespace

void PathScenario::Validate() const {
  const std::size_t points = points_m.size();
  if (!attitudes_rad.empty()) {
    Demand(!attitude_rad, "attitude_rad and attitudes_rad are both given: remove one of them");
    Demand(kind == PathKind::kLine || kind == PathKind::kSpline,
           "attitudes_rad is valid only for a line or a spline: give attitude_rad instead");
    Demand(attitudes_rad.size() == points,
           fmt::format("points_m has {} entries and attitudes_rad has {}: give one attitude per point",
                       points, attitudes_rad.size()));
  }
  if (kind == PathKind::kCircle) return;
  if (kind == PathKind::kFile)
    return Demand(file.has_value(), "a path of kind file needs a file: for example file: scan.csv");
  if (kind == PathKind::kWaypoints) return CheckWaypoints(waypoints);
  if (kind == PathKind::kHold) {
    Demand(points == 1, fmt::format("a path of kind hold needs one entry in points_m, found {}", points));
    return;
  }
  Demand(kind != PathKind::kLine || points == 2,
         fmt::format("a path of kind line needs two entries in points_m, found {}", points));
  Demand(times_s.size() == points,
         fmt::format("points_m has {} entries and times_s has {}: give one time per point", points,
                     times_s.size()));
  for (std::size_t i = 0; i < times_s.size(); ++i)
    Demand(std::isfinite(times_s[i]) && (i == 0 || times_s[i] > times_s[i - 1]),
           fmt::format("times_s.{} = {}: the times must be finite and increase", i, times_s[i]));
}

namespace {

/// Points and times of waypoints, with two equal points for each dwell.
PathTable TableOf(const std::vector<WaypointScenario>& waypoints) {
  PathTable table;
  double time = 0;
  std::optional<Eigen::Vector3d> attitude;
  const auto add = [&](const Eigen::Vector3d& position) {
    table.times.push_back(time);
    table.points.push_back(position);
    if (attitude) table.attitudes.push_back(*attitude);
  };
  for (const WaypointScenario& waypoint : waypoints) {
    if (waypoint.travel_s) time += *waypoint.travel_s;
    if (waypoint.speed_m_per_s)
      time += (waypoint.position_m - table.points.back()).norm() / *waypoint.speed_m_per_s;
    if (waypoint.attitude_rad) attitude = waypoint.attitude_rad;
    add(waypoint.position_m);
    if (waypoint.dwell_s == 0) continue;
    time += waypoint.dwell_s;
    add(waypoint.position_m);
  }
  return table;
}

PlatformPath Through(const PathTable& table) {
  PlatformPath path{Path::Waypoints(table.points, table.times), {}};
  if (!table.attitudes.empty()) path.attitude = Path::Waypoints(table.attitudes, table.times);
  return path;
}

PlatformPath MakePath(const PathScenario& path) {
  switch (path.kind) {
    case PathKind::kHold:
      return {Path::Hold(path.points_m[0]), {}};
    case PathKind::kLine:
    case PathKind::kSpline: {
      PlatformPath spline{Path::Spline(path.points_m, path.times_s), {}};
      if (!path.attitudes_rad.empty()) spline.attitude = Path::Spline(path.attitudes_rad, path.times_s);
      return spline;
    }
    case PathKind::kWaypoints:
      return Through(TableOf(path.waypoints));
    case PathKind::kFile:
      return Through(ReadPathFile(ResourceMap(*path.file).Text("file")));
    case PathKind::kCircle:
      break;
  }
  const Eigen::Vector3d along =
      path.plane == CirclePlane::kYz ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d across =
      path.plane == CirclePlane::kXy ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  return {Path::Circle(path.center_m, path.radius_m, path.period_s, path.ramp_s, along, across), {}};
}

}  // namespace

PlatformPath PathScenario::Make() const {
  PlatformPath path = MakePath(*this);
  constexpr double kLongest = 3600;  // s
  const double begin = path.position.start_time(), end = path.position.end_time();
  Demand(path.position.is_periodic() || end - begin <= kLongest,
         fmt::format("{}: the path lasts {:.10g} s, but may last at most {} s: shorten it",
                     kind == PathKind::kFile        ? "file"
                     : kind == PathKind::kWaypoints ? "waypoints"
                                                    : "times_s",
                     end - begin, kLongest));
  Demand(!path.attitude || !attitude_rad,
         "the path has both attitudes at its points and attitude_rad: remove one of them");
  Demand(
      tension_aim_N == 0 || path.attitude || attitude_rad,
      fmt::format("tension_aim_N = {} needs attitude_rad: add it, or remove tension_aim_N", tension_aim_N));
  return path;
}

void HangingLoadScenario::Validate() const {
  Demand(swing_m.norm() < length,
         fmt::format("swing_m has a length of {:.4g} m, but must be shorter than the rope, length_m = {}",
                     swing_m.norm(), length));
}

void CdprScenario::Validate() const {
  Demand(!known_additions || controller != CdprController::kPd,
         "known_additions has no effect on controller 'pd', which does not use the load: choose "
         "pd_feedforward, or remove known_additions");
}

namespace {

/// Number of periods in a horizon, at least one.
int PeriodsIn(double horizon_s, double rate_hz) {
  return std::max(1, static_cast<int>(std::lround(horizon_s * rate_hz)));
}

/// Gains of a scenario, from its keys and for the others from its profile.
CdprProfile GainsOf(const CdprScenario& scenario, const CdprDescription& robot,
                    const Eigen::Vector3d& start) {
  const MpcScenario& mpc = scenario.mpc;
  const PdScenario& pd = scenario.pd;
  CdprProfile gains;
  if (!mpc.horizon_s || !mpc.num_steps || !mpc.weights || !pd.stiffness_N_per_m || !pd.damping_N_s_per_m)
    gains = Blame("profile", [&] { return LoadCdprProfile(scenario.profile, ScaleOf(robot, start)); });
  // A horizon of the profile is a multiple of the period and has a period per step at least.
  auto& [horizon, num_steps, weights] = gains.mpc;
  const double rate_hz = mpc.params.rate.hz();
  horizon = mpc.horizon_s.value_or(PeriodsIn(horizon, rate_hz) / rate_hz);
  num_steps = mpc.num_steps.value_or(std::min(num_steps, PeriodsIn(horizon, rate_hz)));
  weights = mpc.weights.value_or(weights);
  gains.pd.stiffness = pd.stiffness_N_per_m.value_or(gains.pd.stiffness);
  gains.pd.damping = pd.damping_N_s_per_m.value_or(gains.pd.damping);
  return gains;
}

CdprMpcParams MakeMpcParams(const CdprScenario& scenario, const CdprMpcGains& gains,
                            const std::shared_ptr<const EquilibriumPath>& path) {
  CdprMpcParams params = scenario.mpc.params;
  params.path = path;
  params.equilibrium_input = scenario.controller != CdprController::kMpcZero;
  params.horizon = gains.horizon;
  params.num_steps = gains.num_steps;
  params.weights = params.terminal_weights = gains.weights;
  params.slq = scenario.mpc.slq;
  if (scenario.controller == CdprController::kMpcThesis) {
    params.num_steps = PeriodsIn(gains.horizon, params.rate.hz());
    params.terminal = TerminalCost::kGiven;
    params.slq.bounds = SlqBounds::kRollOutProjection;
    params.command_rate = params.rate;
  }
  if (scenario.controller == CdprController::kLqr) {
    params.num_steps = 2;
    params.horizon = 2 / params.rate.hz();
  }
  return params;
}

}  // namespace

CdprLoopParams MakeLoopParams(const CdprScenario& scenario) {
  CdprLoopParams params;
  params.robot = Blame("robot", [&] { return LoadCdpr(scenario.robot); });
  CdprDescription believed = params.robot;
  if (!scenario.known_pulleys) believed.RemovePulleys();
  believed.mass *= 1 + scenario.mpc.mass_error;
  believed.inertia_B *= 1 + scenario.mpc.mass_error;
  const PlatformPath path = Blame("path", [&] { return scenario.path.Make(); });
  const auto equilibria = [&](const CdprDescription& robot) {
    return std::make_shared<EquilibriumPath>(
        robot, path.position,
        StaticsOptions{.attitude = scenario.path.attitude_rad, .tension_aim = scenario.path.tension_aim_N},
        path.attitude);
  };
  params.path = Blame("path", [&] {
    try {
      return equilibria(believed);
    } catch (const ParameterError& error) {
      if (believed.mass == params.robot.mass) throw;
      equilibria(params.robot);  // throws if the path is infeasible for the true mass, too
      throw KeyError("mpc.mass_error", error.what());
    }
  });
  const CdprProfile gains =
      GainsOf(scenario, believed, path.position.At(path.position.start_time()).position);
  Blame("pd", [&] {
    gains.pd.stiffness.CheckSize("stiffness_N_per_m", believed.num_cables(), "cables");
    gains.pd.damping.CheckSize("damping_N_s_per_m", believed.num_cables(), "cables");
  });
  if (IsMpc(scenario.controller))
    params.mpc = Blame("mpc", [&] {
      CdprMpcParams mpc = MakeMpcParams(scenario, gains.mpc, params.path);
      mpc.Validate();
      return mpc;
    });
  params.feedforward = scenario.controller == CdprController::kPdFeedforward;
  const bool estimates =
      scenario.controller == CdprController::kMpcEquilibrium || scenario.controller == CdprController::kLqr;
  params.offset_free =
      scenario.controller == CdprController::kPdOffsetFree || (estimates && scenario.mpc.offset_free);
  LoadEstimatorParams& load = params.load.emplace(MakeLoadEstimator(params.mpc.has_value()));
  load.robot = params.robot;
  load.rate = scenario.noise.pose.rate;
  load.bandwidth = scenario.load.bandwidth_rad_per_s.value_or(load.bandwidth);
  load.mass_bandwidth = scenario.load.mass_bandwidth_rad_per_s.value_or(load.mass_bandwidth);
  if (*params.offset_free) Blame("load", [&] { load.Validate(); });
  params.start_offset = scenario.start_offset_m;
  params.start_turn = scenario.start_turn_rad;
  params.control_rate = scenario.pd.rate;
  params.pd_stiffness_N_per_m = gains.pd.stiffness;
  params.pd_damping_N_s_per_m = gains.pd.damping;
  params.payload = scenario.payload;
  if (scenario.dynamics == Dynamics::kSimbody) params.extend = [](CdprMultibody&) {};
  if (!scenario.attached.empty()) params.extend = AttachToPlatform(scenario.attached);
  params.known_additions = scenario.known_additions;
  params.gusts.gusts = scenario.gusts;
  if (scenario.hanging_load) {
    params.hanging_load = *scenario.hanging_load;
    params.hanging_load->axial_stiffness = params.robot.cable.axial_stiffness;
    params.hanging_load->axial_damping = params.robot.cable.axial_damping;
    params.swing << scenario.hanging_load->swing_m, 0;
  }
  params.pose_sensor = scenario.noise.pose;
  params.imu = scenario.noise.imu;
  // The filter's model has the noise of its sensors, with a lower bound for perfect ones.
  params.estimator.rate = params.pose_sensor.rate;
  params.estimator.noise.position = std::max(params.pose_sensor.position_noise.maxCoeff(), 1e-4);
  params.estimator.noise.attitude = std::max(params.pose_sensor.attitude_noise.maxCoeff(), 1e-4);
  params.estimator.noise.angular_velocity = std::max(params.imu.angular_velocity_noise.maxCoeff(), 1e-4);
  params.estimator.noise.specific_force = std::max(params.imu.specific_force_noise.maxCoeff(), 1e-3);
  Blame("hardware", [&] { SetHardware(scenario.hardware, params); });
  params.forbid_slack = scenario.forbid_slack;
  params.max_tension_ratio = scenario.max_tension_ratio;
  return params;
}

namespace {

/// Length of the path [m]; one turn if it is a circle.
double LengthOf(const Path& path) {
  constexpr double kStep = 0.01;  // s
  const double end = path.is_periodic() ? path.TimeOf(2 * std::numbers::pi) : path.end_time();
  double length = 0;
  for (double t = path.start_time(); t < end; t += kStep)
    length += (path.At(std::min(t + kStep, end)).position - path.At(t).position).norm();
  return length;
}

}  // namespace

PathVerdict MakePathVerdict(const CdprScenario& scenario, bool live) {
  if (live) return {};
  const PlatformPath path = scenario.path.Make();
  const double length = LengthOf(path.position);
  if (length == 0 && !path.attitude) return {};
  return {scenario.path_tolerance, length, scenario.start_offset_m.norm(), scenario.start_turn_rad.norm()};
}

std::string PayOutNote(const EquilibriumPath& equilibria) {
  const CdprDescription& robot = equilibria.robot();
  const Path& path = equilibria.path();
  const double b = robot.winch.reel_damping;
  if (robot.winch.mode != WinchMode::kTension) return "";
  const MovingAnchors& anchors = equilibria.anchors();
  double begin = path.start_time();
  double end = path.is_periodic() ? path.TimeOf(4 * std::numbers::pi) : path.end_time();
  if (anchors.any()) {
    begin = std::min(begin, anchors.start_time());
    end = std::max(end, anchors.end_time());
  }
  constexpr int kSamples = 200;
  constexpr double kTolerance = 1e-3;  // interpolated attitudes are equilibria only nearly
  CdprReference at;
  CableKinematics cables;
  for (int k = 0; k <= kSamples; ++k) {
    const double time = begin + (end - begin) * k / kSamples;
    equilibria.At(time, &at);
    const CableVector least = (b * at.length_rate).cwiseMax(0) + robot.tension_min();
    const Eigen::Matrix3d R_WB = RotationFromEuler(at.euler);
    CalcCableKinematics(robot, at.position, R_WB, &cables, anchors, time);
    const CableMatrix6& structure = cables.structure;
    const Vector6d wrench = -PassiveWrench(robot, at.position, R_WB) - structure * least;
    const CableVector none = CableVector::Zero(robot.num_cables());
    if (DistributeTension(structure, wrench, none, robot.tension_max(), 0, kTolerance).feasible) continue;
    Eigen::Index i = 0;
    at.length_rate.maxCoeff(&i);
    return fmt::format(
        "robot.winch.reel_damping_N_s_per_m = {:.4g} is high for the path: at {:.4g} s cable {} has to pay "
        "out at {:.3g} m/s, which takes {:.3g} N more than the smallest tension, and no such tensions hold "
        "the platform; if it does not follow, lower the damping or slow down the path",
        b, time, i, at.length_rate[i], b * at.length_rate[i]);
  }
  return "";
}

SimulatorOptions MakeSimulatorOptions(const CdprScenario& scenario) {
  SimulatorOptions options = scenario.integrator.Options();
  options.seed = scenario.seed;
  return options;
}

namespace {

constexpr const char* kPositions = "t,x,y,z";
constexpr const char* kPoses = "t,x,y,z,roll,pitch,yaw";

std::vector<std::string_view> Cells(std::string_view line) {
  std::vector<std::string_view> cells;
  internal::Split(line, ',', [&](std::string_view cell) { cells.push_back(internal::Trimmed(cell)); });
  return cells;
}

}  // namespace

PathTable ReadPathFile(const std::string& file) {
  std::ifstream in = OpenInput(file);
  if (!in.is_open())
    throw ParameterError(fmt::format("{}: cannot be read: give the path of a CSV file", file));
  PathTable table;
  std::string line;
  int number = 1;
  const auto refuse = [&](const std::string& what) {
    throw ParameterError(fmt::format("{}:{}: {}", file, number, what));
  };
  std::getline(in, line);
  if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // a byte-order mark
  const std::string header = fmt::format("{}", fmt::join(Cells(line), ","));
  if (header != kPositions && header != kPoses)
    refuse(fmt::format("the columns are '{}': give '{}' or '{}', in s, m and rad", internal::Excerpt(header),
                       kPositions, kPoses));
  const std::size_t columns = header == kPoses ? 7 : 4;

  while (std::getline(in, line)) {
    ++number;
    if (internal::Trimmed(line).empty()) continue;
    std::vector<double> row;
    for (const std::string_view cell : Cells(line)) {
      const auto value = internal::NumberIn<double>(cell);
      if (!value || !std::isfinite(*value))
        refuse(fmt::format("'{}' is not a finite number", internal::Excerpt(std::string(cell))));
      row.push_back(*value);
    }
    if (row.size() != columns)
      refuse(fmt::format("{} values, but the header names {} columns", row.size(), columns));
    if (!table.times.empty() && row[0] <= table.times.back())
      refuse(fmt::format("t = {} s does not come after the {} s of the row before: times must increase",
                         row[0], table.times.back()));
    table.times.push_back(row[0]);
    table.points.emplace_back(row[1], row[2], row[3]);
    if (columns == 7) table.attitudes.emplace_back(row[4], row[5], row[6]);
  }
  if (table.times.size() < 2) refuse(fmt::format("{} points: a path needs two or more", table.times.size()));
  return table;
}

}  // namespace tenon::apps
