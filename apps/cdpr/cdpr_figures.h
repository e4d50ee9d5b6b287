#pragma once

#include <tenon/apps/common/real_time.h>
#include <tenon/apps/common/verdicts.h>
#include <tenon/controllers/cdpr/cable_interference.h>
#include <tenon/controllers/cdpr/cdpr_clearance.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>

namespace tenon::apps {

/// Figures of a cable robot's run, computed row by row from a log of Signals.
class CdprFigures final : public LogSink {
 public:
  /// Signals to log.
  static std::vector<const Source*> Signals(const CdprLoop& loop);

  /// A load is attached from `loaded_from` to `settle_from` [s]; the settling time begins at `settle_from`.
  CdprFigures(const CdprLoop& loop, double loaded_from, double settle_from, const PathVerdict& path = {})
      : loop_(loop), loaded_from_(loaded_from), settle_from_(settle_from), path_(path) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;

  /// Adds the figures, without that of the path.
  void AddTo(Summary& summary) const;
  const PathVerdict& path() const { return path_; }

 private:
  /// Standard deviation of roll, pitch and yaw from 3 s after the load is attached until it is released
  /// [rad]; empty without such a time.
  std::optional<double> LoadedSwing() const;

  const CdprLoop& loop_;
  double loaded_from_, settle_from_;
  PathVerdict path_;
  Logged<PlatformState> platform_;
  Logged<Vec<3>> euler_, ref_position_, ref_euler_;
  Logged<PlatformAcceleration> acceleration_;
  std::vector<std::size_t> tensions_, commands_;

  double last_time_ = 0;
  std::vector<double> last_tension_;
  Tally tension_, tension_rate_, command_;  // of all cables [N], [N/s], [N]
  Tally oscillation_, accelerations_;       // attitude minus that of the equilibrium [rad], [m/s^2]
  /// Tracking error, the one from 3 s after a load is attached until its release, and that from then on [m].
  Tally error_, loaded_error_, release_error_;
  std::array<Tally, 3> loaded_euler_;
  std::optional<double> settled_since_;  // since when x and y are within 0.02 m of the reference [s]
};

/// Statistics of an MPC's solves, from a log of Signals at its rate. There are none if a controller without
/// `diagnostics` replaced the MPC.
class MpcFigures final : public LogSink {
 public:
  static std::vector<const Source*> Signals(const CdprMpc& mpc) {
    return Present<Source>({&mpc.diagnostics});
  }

  explicit MpcFigures(const CdprMpc& mpc) : mpc_(mpc) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override {
    solves_.Begin(names, FindCurrent(mpc_.diagnostics), &CdprMpcDiagnostics::fallbacks);
  }
  void Row(std::span<const double> row) override { solves_.Row(row); }
  void AddTo(Summary& summary) const { solves_.AddTo(summary, "mpc", "mpc_fallbacks"); }

 private:
  const CdprMpc& mpc_;
  SolveFigures solves_;
};

/// The robot of the plant that stands in the diagram, see CurrentAs.
inline const CdprDescription& RobotOf(const CdprPlant& plant) {
  return CurrentAs<LeafSystem<CdprPlantParams>>(plant).params.robot;
}

/// Checks that a run of a CdprLoop was physically possible, from a log at each tick of its controller:
///
/// The distance between two cables, as straight lines from anchors or pulleys, is at least their diameter.
/// Pairs that touch at the start are assumed to be guided past each other, like the crossed cables of cdpr_8,
/// and are not checked.
///
/// No cable runs through the platform, see CableInterference. If one does at the start, the platform is
/// assumed to be an open frame and is not checked. Cables without tension are not checked.
///
/// The platform's box and the cables with tension touch none of the robot's obstacles.
///
/// The platform's box, payload, hanging load, added bodies and cables, with their sag, stay above the floor,
/// z = 0. The heading differs from its reference by at most a quarter turn: the restoring moment of the
/// cables is proportional to the sine of that angle.
///
/// Slack cables and the largest tension are checked by CdprMonitor. The limits of a plant with other
/// parameters than CdprPlantParams are unknown, and nothing is checked.
class CdprLimits final : public LogSink {
 public:
  /// The signals that must be logged.
  static std::vector<const Source*> Signals(const CdprLoop& loop);

  /// `cable_diameter` is the distance below which two cables touch [m].
  CdprLimits(const CdprLoop& loop, double cable_diameter);
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;
  /// Adds the figures with their limits, and the breaches, to the summary.
  void AddTo(Summary& summary) const;

 private:
  void DistanceRow(std::span<const double> row, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);
  void PlatformRow(std::span<const double> row, const Eigen::Matrix3d& R_WB);
  void FloorRow(std::span<const double> row, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB);

  const CdprLoop& loop_;
  bool known_;  // whether the limits of the plant in the diagram are known
  CdprDescription robot_;
  MovingAnchors anchors_;
  AddedShapes added_;
  double cable_diameter_;
  Eigen::Vector3d box_;  // half edges of the platform's box [m]
  CableInterference interference_;
  CdprClearance clearance_;  // from obstacles, and of cables that do not touch at the start
  CableKinematics all_;      // kinematics of the cables at the current row
  bool started_ = false;
  bool open_frame_ = false;
  Logged<PlatformState> platform_;
  Logged<Payload> payload_;
  Logged<HangingLoadState> load_;
  Logged<Vec<3>> euler_, reference_;
  std::vector<std::size_t> tension_;
  std::vector<std::pair<std::size_t, std::size_t>>
      pieces_;  // columns of height and tension of sagging cables

  Tally distances_, angles_, clearances_, heights_, turns_;  // [m], [rad], [m], [m], [rad]
  Breaches breaches_;
};

}  // namespace tenon::apps
