#pragma once

#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/verdicts.h>
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
  std::vector<std::size_t> position_, euler_, a_W_, tensions_, commands_, ref_position_, ref_euler_;

  double last_time_ = 0;
  std::vector<double> last_tension_;
  Tally tension_, tension_rate_, command_;  // of all cables [N], [N/s], [N]
  Tally oscillation_, acceleration_;        // attitude minus that of the equilibrium [rad], [m/s^2]
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
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;

  void AddTo(Summary& summary) const;

 private:
  const CdprMpc& mpc_;
  std::optional<std::size_t> time_, count_;
  TimeQuantiles times_;  // wall-clock times of the solves [s]
  std::optional<double> fallbacks_;
};

}  // namespace tenon::apps
