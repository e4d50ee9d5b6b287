#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tenon/diagrams/cdpr/cdpr_loop.h>
#include <tenon/systems/simulation/signal_log.h>

namespace tenon::apps {

/// The figures of a cable robot's run, gathered row by row from a log of the Signals of its CdprLoop.
class CdprFigures final : public LogSink {
 public:
  /// What has to be logged for it; the loop is called `loop` in its diagram.
  static std::vector<const Source*> Signals(const CdprLoop& loop);

  /// `settle_from` [s]: the settling time counts from here.
  explicit CdprFigures(double settle_from) : settle_from_(settle_from) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;

  double tension_min() const { return tension_min_; }  ///< of the plant [N]
  double tension_max() const { return tension_max_; }
  double command_min() const { return command_min_; }  ///< [N]
  double command_max() const { return command_max_; }
  double tension_rate_rms() const;       ///< of the plant, all cables [N/s]
  double euler_oscillation_rms() const;  ///< attitude minus that of the equilibrium [rad]
  double acceleration_rms() const;       ///< [m/s^2]
  double tracking_error_rms() const;     ///< [m]
  /// Since `settle_from`, until x and y stay within 0.02 m of the reference [s]; empty if they never do.
  std::optional<double> settling_time() const;

 private:
  double settle_from_;
  std::vector<std::size_t> position_, euler_, acceleration_, tension_, command_, ref_position_, ref_euler_;

  long rows_ = 0, rate_rows_ = 0;
  double last_time_ = 0;
  std::vector<double> last_tension_;
  double tension_min_ = 0, tension_max_ = 0, command_min_ = 0, command_max_ = 0;
  double rate_square_ = 0, euler_square_ = 0, acceleration_square_ = 0, error_square_ = 0;
  double settled_since_ = 0;
  bool settled_ = false;
};

/// How the solves of an MPC went, from a log of its `diagnostics` at its own rate.
class MpcFigures final : public LogSink {
 public:
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;

  /// Wall-clock time of a solve that the part `share` of all solves does not exceed [s].
  double time_quantile(double share) const;
  double fallbacks() const { return fallbacks_; }

 private:
  std::size_t time_ = 0, count_ = 0;
  std::vector<double> times_;
  double fallbacks_ = 0;
};

}  // namespace tenon::apps
