#include <tenon/controllers/cdpr/cdpr_workspace.h>
#include <tenon/plants/signals/quaternion.h>

#include <fmt/core.h>

namespace tenon {
namespace {

constexpr double kMostCells = 1e7;

class Mapper {
 public:
  Mapper(PoseFeasibility& robot, const WorkspaceOptions& options) : robot_(robot), options_(options) {}

  std::vector<WorkspaceCell> Map() {
    Divide({.size = options_.grid.cells});
    return std::move(found_);
  }

 private:
  void Divide(WorkspaceCell part) {
    const bool whole = part.size == std::array{1, 1, 1};
    Judge(&part, whole);
    const bool known = part.wrench == PoseVerdict::kFails ||
                       (part.wrench == PoseVerdict::kHolds && part.clear != PoseVerdict::kUndecided);
    if (known || whole) return Add(part);
    std::size_t axis = 0;
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double length = part.size[k] * options_.grid.cell()[k];
      if (part.size[k] == 1 || length <= longest) continue;
      longest = length;
      axis = k;
    }
    WorkspaceCell lower = part, upper = part;
    lower.size[axis] = part.size[axis] / 2;
    upper.first[axis] += lower.size[axis];
    upper.size[axis] -= lower.size[axis];
    Divide(lower);
    Divide(upper);
  }

  /// Interference is not needed for a part that is divided anyway.
  void Judge(WorkspaceCell* part, bool whole) {
    const Eigen::Vector3d centre = part->centre(options_.grid);
    const Eigen::Vector3d size(part->size[0], part->size[1], part->size[2]);
    const double reach = size.cwiseProduct(options_.grid.cell()).norm() / 2;
    PoseBall ball = options_.PoseAt(centre);
    (options_.kind == WorkspaceKind::kPosition ? ball.distance : ball.angle) = reach;
    part->wrench = robot_.Over(ball);
    part->margins = robot_.margins();
    part->clear = PoseVerdict::kUndecided;
    part->clearance = {};
    if (part->wrench == PoseVerdict::kFails || (part->wrench == PoseVerdict::kUndecided && !whole)) return;
    part->clear = robot_.IsClearOver(ball, options_.cable_diameter);
    part->clearance = robot_.clearance();
  }

  void Add(const WorkspaceCell& part) {
    found_.push_back(part);
    done_ += part.volume(options_.grid);
    if (options_.progress && found_.size() % 256 == 0) options_.progress(done_ / options_.grid.volume());
  }

  PoseFeasibility& robot_;
  const WorkspaceOptions& options_;
  std::vector<WorkspaceCell> found_;
  double done_ = 0;
};

}  // namespace

/// The product of the edges that are above 0.
static double Measure(const Eigen::Vector3d& edges) {
  const auto extends = edges.array() > 0;
  return extends.all() ? edges.prod() : extends.select(edges, 1).prod();
}

double WorkspaceGrid::volume() const {
  return Measure(high - low);
}

WorkspaceGrid WorkspaceGrid::OfSize(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double cell) {
  WorkspaceGrid grid{low, high};
  grid.Validate();
  if (!(cell > 0) || !std::isfinite(cell))
    throw ParameterError(fmt::format("cells of {}: give a size above 0", cell));
  for (int k = 0; k < 3; ++k) {
    const double count = std::ceil((high[k] - low[k]) / cell - 1e-9);
    grid.cells[k] = static_cast<int>(std::clamp(count, 1.0, kMostCells));
  }
  grid.Validate();
  return grid;
}

void WorkspaceGrid::Validate() const {
  double count = 1;
  for (int k = 0; k < 3; ++k) {
    if (!std::isfinite(low[k]) || !std::isfinite(high[k]) || !(low[k] <= high[k]) || dimensions() == 0)
      throw ParameterError(
          fmt::format("the box of a workspace goes from {} to {} along {}: give a lower and a higher end",
                      low[k], high[k], "xyz"[k]));
    if (cells[k] < 1)
      throw ParameterError(fmt::format("{} cells along {}: one at least", cells[k], "xyz"[k]));
    count *= cells[k];
  }
  if (count > kMostCells)
    throw ParameterError(fmt::format(
        "{:.3g} cells are more than {:.0e}: make the cells larger or the box smaller", count, kMostCells));
}

Eigen::Vector3d WorkspaceGrid::cell() const {
  return (high - low).cwiseQuotient(Eigen::Vector3d(cells[0], cells[1], cells[2]));
}

Eigen::Vector3d WorkspaceCell::centre(const WorkspaceGrid& grid) const {
  const Eigen::Vector3d middle(first[0] + 0.5 * size[0], first[1] + 0.5 * size[1], first[2] + 0.5 * size[2]);
  return grid.low + middle.cwiseProduct(grid.cell());
}

double WorkspaceCell::volume(const WorkspaceGrid& grid) const {
  return Measure(grid.cell()) * size[0] * size[1] * size[2];
}

PoseVerdict WorkspaceCell::verdict() const {
  if (wrench == PoseVerdict::kFails || clear == PoseVerdict::kFails) return PoseVerdict::kFails;
  return wrench == PoseVerdict::kHolds && clear == PoseVerdict::kHolds ? PoseVerdict::kHolds
                                                                       : PoseVerdict::kUndecided;
}

PoseBall WorkspaceOptions::PoseAt(const Eigen::Vector3d& coordinates) const {
  if (kind == WorkspaceKind::kPosition) return {.p_WB = coordinates, .R_WB = R_WB};
  return {.p_WB = p_WB, .R_WB = RotationFromQuaternion(QuaternionFromRotationVector(coordinates)) * R_WB};
}

std::vector<WorkspaceCell> MapWorkspace(PoseFeasibility& robot, const WorkspaceOptions& options) {
  options.grid.Validate();
  return Mapper(robot, options).Map();
}

PoseFeasibility WrenchClosure(CdprDescription robot) {
  for (CableDescription& cable : robot.cables) cable.tension_min = cable.tension_max = {};
  robot.cable.tension_min = 1e-3;
  robot.cable.tension_max = 1;
  robot.springs.clear();
  return {robot, {Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6)}};
}

std::vector<std::optional<StaticEquilibrium>> MapEquilibria(const CdprDescription& robot,
                                                            const WorkspaceGrid& grid,
                                                            const std::function<void(double)>& progress) {
  grid.Validate();
  std::vector<std::optional<StaticEquilibrium>> found;
  const auto [x_cells, y_cells, z_cells] = grid.cells;
  bool any = false;
  WorkspaceCell cell{.size = {1, 1, 1}};
  auto& [i, j, k] = cell.first;
  for (k = 0; k < z_cells; ++k) {
    for (j = 0; j < y_cells; ++j) {
      if (progress) progress((k + j / static_cast<double>(y_cells)) / z_cells);
      for (i = 0; i < x_cells; ++i) {
        StaticsOptions options;
        const auto start_at = [&](bool exists, int cells_back) {
          if (exists && !options.warm_start)
            options.warm_start = found[found.size() - static_cast<std::size_t>(cells_back)];
        };
        start_at(i > 0, 1);
        start_at(j > 0, x_cells);
        start_at(k > 0, x_cells * y_cells);
        try {
          found.emplace_back(SolveInverseGeometricoStatic(robot, cell.centre(grid), options));
          any = true;
        } catch (const ParameterError&) {  // not in the workspace
          found.emplace_back();
        }
      }
    }
  }
  if (!any) static_cast<void>(SolveInverseGeometricoStatic(robot, (grid.low + grid.high) / 2));
  return found;
}

WorkspaceVolume VolumeOf(const std::vector<WorkspaceCell>& cells, const WorkspaceGrid& grid,
                         std::optional<double> diameter) {
  WorkspaceVolume volume;
  for (const WorkspaceCell& cell : cells) {
    const double v = cell.volume(grid);
    const PoseVerdict verdict = diameter ? cell.verdict() : cell.wrench;
    if (verdict == PoseVerdict::kHolds) volume.proven += v;
    if (verdict != PoseVerdict::kFails) volume.possible += v;
    if (cell.margins.feasible() && (!diameter || cell.centre_clear(*diameter))) volume.centres += v;
  }
  return volume;
}

}  // namespace tenon
