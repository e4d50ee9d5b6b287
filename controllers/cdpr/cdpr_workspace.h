#pragma once

#include <tenon/controllers/cdpr/inverse_geometrico_static.h>
#include <tenon/controllers/cdpr/pose_feasibility.h>

#include <functional>

namespace tenon {

/// A box of three coordinates, divided into equal cells. A planar robot has coordinates with low = high: the
/// box is then a rectangle or a line, and volumes are areas or lengths.
struct WorkspaceGrid {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
  std::array<int, 3> cells{1, 1, 1};

  /// Grid with cells of about the size `cell`.
  static WorkspaceGrid OfSize(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double cell);
  Eigen::Vector3d cell() const;
  double volume() const;
  /// Number of coordinates in which the box extends.
  int dimensions() const { return static_cast<int>((high.array() > low.array()).count()); }
  void Validate() const;  ///< throws ParameterError
};

/// A part of the grid, one cell or many, with one verdict of wrenches and one of interference.
struct WorkspaceCell {
  std::array<int, 3> first{}, size{};  ///< in cells of the grid
  PoseVerdict wrench = PoseVerdict::kUndecided;
  PoseVerdict clear = PoseVerdict::kUndecided;
  WrenchMargins margins{};  ///< margins at the part's centre
  /// Clearance at the part's centre; the default if no pose of the part is wrench-feasible.
  CableClearance clearance{};

  Eigen::Vector3d centre(const WorkspaceGrid& grid) const;
  double volume(const WorkspaceGrid& grid) const;
  bool centre_clear(double diameter) const { return clearance.cables >= diameter && clearance.platform >= 0; }
  /// Verdict of wrenches and clearance together.
  PoseVerdict verdict() const;
};

/// Meaning of the three coordinates of a grid.
enum class WorkspaceKind {
  kPosition,  ///< position of the CoM in W [m], at one attitude: the constant-orientation workspace
  kAttitude,  ///< a rotation vector in W [rad] from one attitude, at one position: the orientation workspace
};

struct WorkspaceOptions {
  WorkspaceKind kind = WorkspaceKind::kPosition;
  WorkspaceGrid grid;
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();  ///< position of kAttitude [m]
  Eigen::Matrix3d R_WB =
      Eigen::Matrix3d::Identity();  ///< attitude for kPosition, zero of the vector for kAttitude
  double cable_diameter = 0;        ///< [m]
  /// Called repeatedly with the share of the box that is done; may throw to cancel.
  std::function<void(double)> progress = {};

  /// Pose at the three coordinates.
  PoseBall PoseAt(const Eigen::Vector3d& coordinates) const;
};

/// Divides the box into parts that are feasible everywhere, infeasible everywhere, or undecided at the size
/// of one cell, by bisection. Parts do not overlap and fill the box.
///
/// Two rotation vectors that differ by delta describe attitudes that differ by at most |delta|, because the
/// space of rotations is curved.
std::vector<WorkspaceCell> MapWorkspace(PoseFeasibility& robot, const WorkspaceOptions& options);

/// Wrench closure: whether tensions that are large enough produce any wrench, whatever the bounds of the
/// robot (Morlando 2023, section 3.1). Here the tensions are between 0.001 and 1, and the required wrench is
/// 0: if tensions within these bounds are in balance and W has full rank, adding multiples of them to any
/// tensions makes these positive. The margins are those of these tensions; `capacity` is the largest wrench
/// in every direction over the largest tension. Only robots with more cables than motions have such poses.
PoseFeasibility WrenchClosure(CdprDescription robot);

/// Returns the stable equilibrium at the centre of each cell, x fastest; empty where the robot cannot rest
/// there within its tension bounds. For robots with fewer than six cables, which do not prescribe an
/// attitude: see SolveInverseGeometricoStatic(). Warm starts follow the equilibria of neighbouring cells.
/// `progress` is called with the share that is done.
/// @throws ParameterError with the reason at the middle of the box if there is none at all.
std::vector<std::optional<StaticEquilibrium>> MapEquilibria(const CdprDescription& robot,
                                                            const WorkspaceGrid& grid,
                                                            const std::function<void(double)>& progress);

/// Bounds of a volume, in the cubed unit of the grid's coordinates.
struct WorkspaceVolume {
  double proven = 0;    ///< volume of cells that are feasible as a whole
  double possible = 0;  ///< volume of cells that are not proven to be infeasible
  double centres = 0;   ///< volume of cells with a feasible centre: an estimate, without proof
};
/// Volume of the cells that are wrench-feasible and, if `diameter` [m] is given, free of interference.
WorkspaceVolume VolumeOf(const std::vector<WorkspaceCell>& cells, const WorkspaceGrid& grid,
                         std::optional<double> diameter = {});

}  // namespace tenon
