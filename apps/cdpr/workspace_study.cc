#include <tenon/apps/cdpr/workspace_study.h>
#include <tenon/controllers/optimization/infinity.h>
#include <tenon/plants/cdpr/cdpr_geometry.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/report/internal/report_json.h>
#include <tenon/systems/report/volume_report.h>
#include <tenon/systems/version.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kCells = 48, kEquilibriumCells = 24;  // along the longest edge
constexpr int kTurnCells = 32;                      // along each axis of the attitudes

/// Grid of positions in the box of the anchors, down to the floor.
WorkspaceGrid PositionGrid(const CdprDescription& robot, const WorkspaceStudyParams& params, int cells) {
  Eigen::Vector3d low = robot.cables[0].anchor_W, high = low;
  for (const CableDescription& cable : robot.cables) {
    low = low.cwiseMin(cable.anchor_W);
    high = high.cwiseMax(cable.anchor_W);
  }
  low.z() = std::min(low.z(), robot.floor);
  if (params.low) low = *params.low;
  if (params.high) high = *params.high;
  if (const auto plane = PlaneOf(robot)) low[plane->normal] = high[plane->normal] = plane->at;
  return WorkspaceGrid::OfSize(low, high, params.cell.value_or((high - low).maxCoeff() / cells));
}

/// Whether all cables end at the CoM.
bool AtCom(const CdprDescription& robot) {
  return robot.ends_in_one_point() && robot.cables[0].attachment_B.isZero(0);
}

/// Number of motions that the cables have to govern, if they prescribe an attitude.
int NumMotions(const CdprDescription& robot) {
  return (PlaneOf(robot) ? 2 : 3) + (AtCom(robot) ? 0 : PlaneOf(robot) ? 1 : 3);
}

/// Least stiffness of the motions that the cables govern; the others are locked.
double StiffnessAt(const CdprDescription& robot, const CableKinematics& cables, const PoseBall& pose,
                   const CableVector& tension) {
  constexpr double kLocked = 1e12;  // [N/m, N m]
  Matrix6d stiffness = CalcElasticStiffness(robot, cables, pose.p_WB, pose.R_WB, tension);
  const std::vector<int> motions = MotionsOf(robot);
  for (int i = 0; i < 6; ++i) {
    if (std::ranges::find(motions, i) != motions.end()) continue;
    stiffness.row(i).setZero();
    stiffness.col(i).setZero();
    stiffness(i, i) = kLocked;
  }
  return CalcLeastTranslationalStiffness(stiffness);
}

/// Stiffness at the centre of each cell that can hold the weight, with the tensions of least norm.
std::vector<double> Stiffness(const CdprDescription& robot, double load, const WorkspaceMap& map) {
  TensionDistributor distributor(robot.num_cables());
  const Vector6d wrench = RequiredWrenches(robot, {.load = load}).centre;
  std::vector<double> stiffness;
  CableKinematics cables;
  for (const WorkspaceCell& cell : map.cells) {
    stiffness.push_back(kNaN);
    if (!cell.margins.feasible()) continue;
    const PoseBall pose = map.options.PoseAt(cell.centre(map.options.grid));
    CalcCableKinematics(robot, pose.p_WB, pose.R_WB, &cables);
    const TensionDistribution& found =
        distributor.Solve(cables.structure, wrench - CalcSpringWrench(robot.springs, pose.p_WB, pose.R_WB),
                          robot.tension_min(), robot.tension_max());
    if (!found.feasible) continue;
    stiffness.back() = StiffnessAt(robot, cables, pose, found.tension);
  }
  return stiffness;
}

/// Returns the feasible centre nearest to the centroid of the feasible cells; empty if none is feasible.
std::optional<Eigen::Vector3d> Middle(const WorkspaceMap& map) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double volume = 0;
  const auto feasible = [&](const WorkspaceCell& cell) { return cell.margins.feasible(); };
  for (const WorkspaceCell& cell : map.cells) {
    if (!feasible(cell)) continue;
    const double v = cell.volume(map.options.grid);
    volume += v;
    sum += v * cell.centre(map.options.grid);
  }
  if (volume == 0) return {};
  std::optional<Eigen::Vector3d> nearest;
  for (const WorkspaceCell& cell : map.cells) {
    const Eigen::Vector3d centre = cell.centre(map.options.grid);
    if (feasible(cell) && (!nearest || (centre - sum / volume).norm() < (*nearest - sum / volume).norm()))
      nearest = centre;
  }
  return nearest;
}

/// Returns the angle [rad] up to which the platform can provably turn about any axis: the distance of the
/// nearest cell that is not proven.
double ProvenTurn(const WorkspaceMap& map) {
  double turn = map.options.grid.high.maxCoeff();
  for (const WorkspaceCell& cell : map.cells) {
    if (cell.wrench == PoseVerdict::kHolds) continue;
    const Eigen::Vector3d half =
        0.5 * Eigen::Vector3d(cell.size[0], cell.size[1], cell.size[2]).cwiseProduct(map.options.grid.cell());
    const double nearest = (cell.centre(map.options.grid).cwiseAbs() - half).cwiseMax(0).norm();
    turn =
        std::min(turn, nearest > 1e-12 ? nearest : 0);  // ignores the rounding error of a cell at the origin
  }
  return turn;
}

/// The name of a volume, area or length with its unit, with `which` before the unit.
std::string VolumeName(const WorkspaceGrid& grid, const char* unit, const std::string& which = "") {
  constexpr std::array kNames{"", "range", "area", "volume"};
  const int n = grid.dimensions();
  return fmt::format("{}{}_{}{}", kNames[static_cast<std::size_t>(n)], which, unit,
                     n == 1 ? "" : std::to_string(n));
}

void AddVolumes(const std::string& name, const WorkspaceMap& map, const WorkspaceVolume& volume,
                WorkspaceStudy* study) {
  auto& figures = study->figures;
  const auto add = [&](const char* which, double value) {
    const char* unit = map.of_attitudes() ? "rad" : "m";
    figures.emplace_back(name + "_" + VolumeName(map.options.grid, unit, which), value);
  };
  if (!map.of_equilibria()) add("_proven", volume.proven);
  add("", volume.centres);
  if (!map.of_equilibria()) add("_possible", volume.possible);
}

void AddFigures(const std::string& name, const WorkspaceMap& map, WorkspaceStudy* study) {
  const double whole = map.options.grid.volume();
  const WorkspaceVolume volume = VolumeOf(map.cells, map.options.grid),
                        clear = VolumeOf(map.cells, map.options.grid, study->params.cable_diameter);
  auto& figures = study->figures;
  AddVolumes(name, map, volume, study);
  figures.emplace_back(name + "_share", volume.centres / whole);
  if (map.closure) return;
  AddVolumes(name + "_clear", map, clear, study);
  if (map.of_equilibria())
    figures.emplace_back(name + "_tilt_max_rad", *std::ranges::max_element(map.tilt));
  else
    figures.emplace_back(name + "_clear_share", clear.centres / whole);
  std::optional<double> margin, capacity, softest, stiffest;
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const WorkspaceCell& cell = map.cells[i];
    if (!cell.margins.feasible()) continue;
    margin = std::max(margin.value_or(0), cell.margins.tension);
    capacity = std::max(capacity.value_or(0), cell.margins.capacity);
    const double stiffness = map.stiffness[i];
    if (!std::isfinite(stiffness)) continue;
    softest = std::min(softest.value_or(stiffness), stiffness);
    stiffest = std::max(stiffest.value_or(stiffness), stiffness);
  }
  figures.emplace_back(name + "_tension_margin_max_N", margin);
  if (!map.of_equilibria()) figures.emplace_back(name + "_capacity_margin_max_N", capacity);
  figures.emplace_back(name + "_stiffness_min_N_per_m", softest);
  figures.emplace_back(name + "_stiffness_max_N_per_m", stiffest);
  if (map.of_attitudes()) figures.emplace_back("any_axis_turn_proven_rad", ProvenTurn(map));
}

std::string Csv(const WorkspaceMap& map) {
  const bool turned = map.of_attitudes();
  const char* unit = turned ? "rad" : "m";
  std::string text;
  for (const char* name : {"x", "y", "z", "size_x", "size_y", "size_z"})
    text += fmt::format("{} [{}],", name, unit);
  text += fmt::format(
      "wrench,clear,tension_margin [N],{},stiffness [N/m],cable_distance [m],cable_platform_sine\n",
      map.of_equilibria() ? "tilt [rad]" : "capacity_margin [N]");
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const WorkspaceCell& cell = map.cells[i];
    const Eigen::Vector3d at = cell.centre(map.options.grid);
    const Eigen::Vector3d size =
        map.options.grid.cell().cwiseProduct(Eigen::Vector3d(cell.size[0], cell.size[1], cell.size[2]));
    text += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{},{:.6g},{:.6g},", at.x(), at.y(),
                        at.z(), size.x(), size.y(), size.z(), EnumName(cell.wrench), EnumName(cell.clear),
                        cell.margins.tension, map.of_equilibria() ? map.tilt[i] : cell.margins.capacity);
    if (std::isfinite(map.stiffness[i])) text += fmt::format("{:.6g}", map.stiffness[i]);
    const bool known = cell.wrench != PoseVerdict::kFails;
    text += known ? fmt::format(",{:.6g},{:.6g}\n", cell.clearance.cables, cell.clearance.platform) : ",,\n";
  }
  return text;
}

/// The robot with its load at the CoM.
CdprDescription Loaded(const WorkspaceStudy& study) {
  CdprDescription robot = study.robot;
  robot.mass += study.params.demand.load;
  return robot;
}

/// Draws the robot at a pose, with the tensions that carry it, or the axes of the attitudes.
Geometry Shapes(const WorkspaceStudy& study, const WorkspaceMap& map) {
  if (map.of_attitudes()) {
    Geometry axes;
    for (int k = 0; k < 3; ++k) {
      if (map.options.grid.high[k] == 0) continue;
      axes.push_back(Shape::Segment(ShapeRole::kFixture, "axis", 0.004));
      axes.back().p_W = map.options.grid.low[k] * Eigen::Vector3d::Unit(k);
      axes.back().vector_W = (map.options.grid.high[k] - map.options.grid.low[k]) * Eigen::Vector3d::Unit(k);
    }
    return axes;
  }
  const CdprDescription& robot = study.robot;
  const auto middle = Middle(map);
  PlatformState platform;
  platform.p_WB = middle.value_or((map.options.grid.low + map.options.grid.high) / 2);
  platform.q_WB = QuaternionFromRotation(RotationFromEuler(study.params.euler));
  CableVector tension = CableVector::Zero(robot.num_cables());
  if (middle && map.of_equilibria()) {
    const StaticEquilibrium rest = SolveInverseGeometricoStatic(Loaded(study), *middle);
    platform.q_WB = QuaternionFromRotation(rest.R_WB);
    tension = rest.tension;
  } else if (middle) {
    const CableKinematics cables = CalcCableKinematics(robot, platform.p_WB, platform.R_WB());
    const Vector6d wrench = RequiredWrenches(robot, {.load = study.params.demand.load}).centre -
                            CalcSpringWrench(robot.springs, platform.p_WB, platform.R_WB());
    tension = DistributeTension(cables.structure, wrench, robot.tension_min(), robot.tension_max()).tension;
  }
  std::vector<CableStatics> cables(robot.cables.size());
  for (std::size_t i = 0; i < cables.size(); ++i) cables[i].exit_W = robot.cables[i].anchor_W;
  Geometry shapes = MakeCdprGeometry(robot);
  MoveCdprGeometry(robot, platform, tension, cables, {}, {}, &shapes);
  return shapes;
}

/// The stable equilibria at the centres of the cells.
WorkspaceMap EquilibriumMap(const WorkspaceStudy& study, const WorkspaceGrid& grid,
                            const std::function<void(const std::string&, double)>& progress) {
  WorkspaceMap map{"positions with a stable equilibrium",
                   {.grid = grid, .cable_diameter = study.params.cable_diameter}};
  const CdprDescription robot = Loaded(study);
  const auto rests = MapEquilibria(robot, grid, [&](double share) { progress(map.title, share); });
  CableInterference interference(robot);
  for (std::size_t n = 0; n < rests.size(); ++n) {
    const auto [x, y, z] = grid.cells;
    const int i = static_cast<int>(n);
    WorkspaceCell cell{{i % x, i / x % y, i / (x * y)},
                       {1, 1, 1},
                       PoseVerdict::kFails,
                       PoseVerdict::kFails,
                       {-kInfinity, -kInfinity, 0}};
    double stiffness = kNaN, tilt = 0;
    if (const auto& rest = rests[n]) {
      const CableKinematics cables = CalcCableKinematics(robot, rest->p_WB, rest->R_WB);
      cell.wrench = PoseVerdict::kHolds;
      cell.margins.tension =
          (rest->tension - robot.tension_min()).cwiseMin(robot.tension_max() - rest->tension).minCoeff();
      cell.clearance = interference.At(cables, rest->R_WB);
      if (cell.centre_clear(study.params.cable_diameter)) cell.clear = PoseVerdict::kHolds;
      stiffness = StiffnessAt(robot, cables, {.p_WB = rest->p_WB, .R_WB = rest->R_WB}, rest->tension);
      tilt = std::acos(std::clamp(rest->R_WB(2, 2), -1.0, 1.0));
    }
    map.cells.push_back(cell);
    map.stiffness.push_back(stiffness);
    map.tilt.push_back(tilt);
  }
  return map;
}

VolumeReport::State StateOf(PoseVerdict verdict) {
  return verdict == PoseVerdict::kHolds   ? VolumeReport::State::kHolds
         : verdict == PoseVerdict::kFails ? VolumeReport::State::kFails
                                          : VolumeReport::State::kUndecided;
}

/// Returns the report's map of wrench feasibility or, with `clear`, of interference as well.
VolumeReport::Map ReportMap(const WorkspaceStudy& study, const WorkspaceMap& map, bool clear) {
  const bool turned = map.of_attitudes();
  VolumeReport::Map shown{
      .title = map.title + (clear ? ", nothing touching" : ""),
      .coordinates = {turned ? "turn_about_x_rad" : "x_m", turned ? "turn_about_y_rad" : "y_m",
                      turned ? "turn_about_z_rad" : "z_m"},
      .low = map.options.grid.low,
      .high = map.options.grid.high,
      .cells = map.options.grid.cells,
      .shapes = Shapes(study, map)};
  // A map of a plane or of a line is as thick as its cells.
  for (int k = 0; k < 3; ++k) {
    if (shown.low[k] < shown.high[k]) continue;
    shown.low[k] -= map.options.grid.cell().maxCoeff() / 2;
    shown.high[k] += map.options.grid.cell().maxCoeff() / 2;
  }
  shown.quantities =
      clear         ? std::vector<std::string>{"cable_distance_m"}
      : map.closure ? std::vector<std::string>{"capacity_per_tension"}
      : map.of_equilibria()
          ? std::vector<std::string>{"tension_margin_N", "tilt_rad", "stiffness_N_per_m"}
          : std::vector<std::string>{"tension_margin_N", "capacity_margin_N", "stiffness_N_per_m"};
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const WorkspaceCell& cell = map.cells[i];
    VolumeReport::Part part{cell.first, cell.size, StateOf(clear ? cell.verdict() : cell.wrench)};
    if (clear) {
      const bool known = cell.wrench != PoseVerdict::kFails && std::isfinite(cell.clearance.cables);
      part.values = {known ? cell.clearance.cables : kNaN};
    } else if (map.closure) {
      part.values = {cell.margins.capacity};
    } else {
      const double second = map.of_equilibria() ? map.tilt[i] : cell.margins.capacity;
      part.values = {cell.margins.tension, second, map.stiffness[i]};
    }
    shown.parts.push_back(std::move(part));
  }
  return shown;
}

std::string Describe(const WorkspaceStudy& study) {
  const CdprDescription& robot = study.robot;
  const PlatformDemand& demand = study.params.demand;
  std::string text = fmt::format("{} cables, {:.4g} kg", robot.num_cables(), robot.mass);
  if (demand.load > 0) text += fmt::format(" and {:.4g} kg of load", demand.load);
  if (demand.acceleration > 0) text += fmt::format(", {:.4g} m/s² along each axis", demand.acceleration);
  if (demand.force > 0) text += fmt::format(", {:.4g} N along each axis", demand.force);
  if (demand.torque > 0) text += fmt::format(", {:.4g} N m about each axis", demand.torque);
  return text + fmt::format("; tensions from {:.4g} to {:.4g} N", robot.tension_min().minCoeff(),
                            robot.tension_max().maxCoeff());
}

}  // namespace

WorkspaceStudy StudyWorkspace(const CdprDescription& given, const WorkspaceStudyParams& params,
                              const std::function<void(const std::string&, double)>& progress) {
  given.Validate();
  params.demand.Validate();
  const auto plane = PlaneOf(given);
  const bool equilibria = given.num_cables() < NumMotions(given) && !AtCom(given);
  if (!equilibria)
    static_cast<void>(PoseFeasibility(given, RequiredWrenches(given, params.demand)));  // refuses some robots
  else if (params.demand.acceleration + params.demand.force + params.demand.torque > 0 ||
           !params.euler.isZero(0) || params.position)
    throw ParameterError(fmt::format(
        "robot '{}' has {} cables, which do not prescribe its attitude: its workspace is that of its stable "
        "equilibria; leave out attitude, position, acceleration, force and torque, or take {} cables",
        given.name, given.num_cables(), NumMotions(given)));
  if (!(params.cable_diameter >= 0) || !std::isfinite(params.cable_diameter))
    throw ParameterError(fmt::format("the cable diameter is {} m: give 0 or more", params.cable_diameter));
  if (!params.euler.allFinite() || !params.position.value_or(Eigen::Vector3d::Zero()).allFinite())
    throw ParameterError("the attitude or the position is not finite: give three numbers each");
  if (plane) {
    const auto [normal, at, motions] = *plane;
    Eigen::Vector3d beside = params.euler;
    beside[normal] = params.position ? (*params.position)[normal] - at : 0;
    if (!beside.isZero(1e-6))
      throw ParameterError(fmt::format(
          "robot '{}' moves in the plane {} = {} m: give a position in it, and an attitude about {} only",
          given.name, "xyz"[normal], at, "xyz"[normal]));
  }
  if (!(params.turn > 0 && params.turn <= M_PI))
    throw ParameterError(
        fmt::format("the largest turn is {} rad: give more than 0 and at most pi", params.turn));
  const auto begin = std::chrono::steady_clock::now();
  WorkspaceStudy study{given, params};
  // Cables are treated as straight lines between points.
  CdprDescription& robot = study.robot;
  robot.cable.mass_per_length = 0;
  robot.RemovePulleys();
  const auto add = [&](const std::string& name, const std::string& title, PoseFeasibility feasibility,
                       WorkspaceOptions options, std::optional<double> load) {
    options.cable_diameter = params.cable_diameter;
    options.progress = [&](double share) { progress(title, share); };
    WorkspaceMap map{title, options};
    map.cells = MapWorkspace(feasibility, options);
    map.closure = !load;
    map.stiffness = load ? Stiffness(robot, *load, map) : std::vector<double>(map.cells.size(), kNaN);
    study.maps.push_back(std::move(map));
    AddFigures(name, study.maps.back(), &study);
  };
  const WorkspaceGrid grid = PositionGrid(robot, params, equilibria ? kEquilibriumCells : kCells);
  const Eigen::Matrix3d R_WB = RotationFromEuler(params.euler);
  study.figures.emplace_back("box_" + VolumeName(grid, "m"), grid.volume());
  const auto seconds = [begin] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  if (equilibria) {
    study.maps.push_back(EquilibriumMap(study, grid, progress));
    AddFigures("equilibrium", study.maps.back(), &study);
    study.wall = seconds();
    return study;
  }
  const PlatformDemand& required = params.demand;
  const auto holding = [&robot](const PlatformDemand& demand) {
    return PoseFeasibility(robot, RequiredWrenches(robot, demand));
  };
  const bool more = required.load + required.acceleration + required.force + required.torque > 0;
  const WorkspaceOptions positions{.grid = grid, .R_WB = R_WB};
  if (more) add("required", "positions with what is required", holding(required), positions, required.load);
  add("static", "positions at rest", holding({}), positions, 0);
  if (robot.num_cables() > NumMotions(robot))
    add("closure", "positions of wrench closure", WrenchClosure(robot), positions, {});

  const auto position = params.position ? params.position : Middle(study.maps[0]);
  if (position) {
    const Eigen::Vector3d p_WB = *position;
    Eigen::Vector3d turn = Eigen::Vector3d::Constant(params.turn);
    if (plane) turn = params.turn * Eigen::Vector3d::Unit(plane->normal);
    add("attitude", fmt::format("attitudes at ({:.2f}, {:.2f}, {:.2f}) m", p_WB.x(), p_WB.y(), p_WB.z()),
        holding(required),
        {.kind = WorkspaceKind::kAttitude,
         .grid = WorkspaceGrid::OfSize(-turn, turn, 2 * params.turn / kTurnCells),
         .p_WB = p_WB,
         .R_WB = R_WB},
        required.load);
  }
  study.wall = seconds();
  return study;
}

void WriteWorkspaceStudy(const WorkspaceStudy& study, const std::filesystem::path& directory) {
  const CdprDescription& robot = study.robot;
  const PlatformDemand& demand = study.params.demand;
  nlohmann::ordered_json summary{{"robot", robot.name},
                                 {"num_cables", robot.num_cables()},
                                 {"mass_kg", robot.mass},
                                 {"tension_min_N", robot.tension_min().minCoeff()},
                                 {"tension_max_N", robot.tension_max().maxCoeff()},
                                 {"load_kg", demand.load},
                                 {"acceleration_m_per_s2", demand.acceleration},
                                 {"force_N", demand.force},
                                 {"torque_N_m", demand.torque},
                                 {"cable_diameter_m", study.params.cable_diameter},
                                 {"wall_s", study.wall},
                                 {"tenon", Version()}};
  for (const auto& [name, value] : study.figures) summary[name] = internal::JsonOrNull(value);
  VolumeReport report{
      .title = robot.name + ": workspace", .description = Describe(study), .figures = study.figures};
  const auto list = [](const Eigen::Vector3d& v) { return nlohmann::ordered_json{v.x(), v.y(), v.z()}; };
  summary["euler_rad"] = list(study.params.euler);
  for (const WorkspaceMap& map : study.maps) {
    const bool turned = map.of_attitudes();
    if (turned) {
      summary["attitude_position_m"] = list(map.options.p_WB);
    } else {
      summary["low_m"] = list(map.options.grid.low);
      summary["high_m"] = list(map.options.grid.high);
      summary["cell_m"] = list(map.options.grid.cell());
    }
    report.maps.push_back(ReportMap(study, map, false));
    if (!map.closure) report.maps.push_back(ReportMap(study, map, true));
    if (turned || &map == study.maps.data())
      WriteFile(directory / (turned ? "attitudes.csv" : "cells.csv"), Csv(map));
  }
  WriteFile(directory / "summary.json", summary.dump(2) + '\n');
  report.Write(directory / "report.html");
}

}  // namespace tenon::apps
