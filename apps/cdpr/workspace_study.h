#pragma once

#include <tenon/controllers/cdpr/cdpr_workspace.h>

#include <filesystem>

namespace tenon::apps {

/// A study of a cable robot's workspaces: positions at one attitude, and attitudes at one position. For
/// robots with fewer than six cables, or three in a plane: positions with a stable equilibrium, whose
/// attitude is free.
struct WorkspaceStudyParams {
  PlatformDemand demand;                               ///< demand of the loaded workspace
  Eigen::Vector3d euler = Eigen::Vector3d::Zero();     ///< ZYX angles of all positions [rad]
  std::optional<Eigen::Vector3d> low = {}, high = {};  ///< limits of positions [m]; the anchors' box if empty
  std::optional<double> cell =
      {};  ///< edge of a cell [m]; if empty 1/48 of the longest edge of the limits, 1/24 for equilibria
  std::optional<Eigen::Vector3d> position =
      {};                         ///< position of all attitudes [m]; the middle of the workspace if empty
  double turn = 0.8;              ///< range of attitudes, about each axis either way [rad]
  double cable_diameter = 0.006;  ///< diameter of all cables [m]
};

/// One workspace: its cells, and the platform's stiffness at the centre of each.
struct WorkspaceMap {
  std::string title;
  WorkspaceOptions options;
  std::vector<WorkspaceCell> cells = {};
  std::vector<double> stiffness = {};  ///< [N/m]; NaN where the centre is not feasible
  std::vector<double> tilt = {};  ///< of the vertical axis at each equilibrium [rad]; empty on proven maps

  bool closure = false;  ///< of wrench closure, see WrenchClosure()

  bool of_attitudes() const { return options.kind == WorkspaceKind::kAttitude; }
  bool of_equilibria() const { return !tilt.empty(); }
};

struct WorkspaceStudy {
  CdprDescription robot;  ///< the robot with weightless cables that start at points
  WorkspaceStudyParams params;
  /// Workspaces of the positions under load, of the positions at rest if it differs, of wrench closure with
  /// seven cables or more, and of the attitudes; or that of the equilibria alone.
  std::vector<WorkspaceMap> maps = {};
  std::vector<std::pair<std::string, std::optional<double>>> figures = {};  ///< names with units
  double wall = 0;                                                          ///< wall-clock time [s]
};

/// Studies the workspaces with pulleys as points and cables without weight. `progress` is called with the
/// name of the current workspace and the completed share; it may throw to cancel. Throws ParameterError.
WorkspaceStudy StudyWorkspace(const CdprDescription& robot, const WorkspaceStudyParams& params,
                              const std::function<void(const std::string&, double)>& progress);

/// Writes summary.json, cells.csv, attitudes.csv and report.html. Throws OutputError, and RunError if parts
/// of the page are not installed.
void WriteWorkspaceStudy(const WorkspaceStudy& study, const std::filesystem::path& directory);

}  // namespace tenon::apps
