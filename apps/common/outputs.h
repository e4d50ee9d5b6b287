#pragma once

#include <tenon/apps/common/summary.h>

namespace tenon::apps {

/// Statistics of a sequence of numbers; empty without numbers, and NaN if one of them was NaN.
class Tally {
 public:
  void Add(double value) {
    low_ = count_ == 0 ? value : std::min(low_, value);
    high_ = count_ == 0 ? value : std::max(high_, value);
    sum_ += value;
    squares_ += value * value;
    ++count_;
  }
  std::optional<double> min() const { return IfAny(low_); }
  std::optional<double> max() const { return IfAny(high_); }
  std::optional<double> mean() const { return IfAny(sum_ / static_cast<double>(count_)); }
  std::optional<double> rms() const { return IfAny(std::sqrt(squares_ / static_cast<double>(count_))); }

 private:
  std::optional<double> IfAny(double figure) const {
    if (count_ == 0) return std::nullopt;
    return std::isnan(squares_) ? squares_ : figure;  // the minimum and the maximum skip NaN
  }
  long count_ = 0;
  double low_ = 0, high_ = 0, sum_ = 0, squares_ = 0;
};

/// Converts a time from s to us.
inline std::optional<double> Microseconds(std::optional<double> seconds) {
  if (seconds) *seconds *= 1e6;
  return seconds;
}

/// The outputs that a customisation adds to a run: signals, shapes in the replay, plots and figures.
///
///     app.Customise([](DiagramBuilder& builder, QuadrupedWalk& walk, Outputs& outputs) {
///       auto& mine = builder.Replace<MyObserver>(walk.observer);
///       outputs.Log(mine.residual);
///       outputs.Plot("residual", {&mine.residual});
///       outputs.Figure("residual_rms_N", mine.residual_norm, &Tally::rms);
///     });
class Outputs {
 public:
  explicit Outputs(DiagramBuilder& builder) : builder_(builder) {}

  /// A statistic of a signal over the run, such as &Tally::max.
  using Statistic = std::optional<double> (Tally::*)() const;

  /// Adds a signal to signals.csv and the report.
  void Log(const Source& signal) { signals_.push_back(&signal); }
  /// Draws an arrow in the replay and on the live page, from a point [m] along scale * vector, both in W; for
  /// a force, `scale` is in m/N. It is shown and hidden with the other shapes of its role.
  void Arrow(std::string name, ShapeRole role, const OutputPort<Vec<3>>& point_W,
             const OutputPort<Vec<3>>& vector_W, double scale);
  /// Draws shapes that a block of your own outputs.
  void Show(const OutputPort<Geometry>& shapes) { shapes_.push_back(&shapes); }
  /// Adds a plot of logged signals to the report, with references that are drawn dashed.
  void Plot(std::string title, std::vector<const Source*> signals,
            std::vector<const Source*> references = {});
  /// Adds a figure to summary.json: a statistic of a signal, sampled at 1 kHz from the time `from` [s] on.
  /// The key ends in the unit.
  void Figure(std::string key, const OutputPort<double>& signal, Statistic statistic, double from = 0);
  /// Adds a log with a sink of your own, and calls `judge` at the end of the run, to set figures from what
  /// the sink has collected.
  void Judge(Rate rate, std::vector<const Source*> signals, std::shared_ptr<LogSink> sink,
             std::function<void(Summary&)> judge) {
    judged_.push_back({rate, std::move(signals), std::move(sink), std::move(judge)});
  }

  /// Adds the logs to the simulator of the built diagram.
  void AddTo(Simulator& simulator) const;
  /// Adds the figures of a completed run.
  void AddTo(Summary& summary) const;
  /// Adds the signals and shapes of this object to the lists, unless they are already in them.
  void AddTo(std::vector<const Source*>& signals, std::vector<const OutputPort<Geometry>*>& shapes) const;
  /// Returns the plots, with the paths of their signals in the built diagram.
  std::vector<tenon::Plot> plots() const;

 private:
  struct Judged {
    Rate rate;
    std::vector<const Source*> signals;
    std::shared_ptr<LogSink> sink;
    std::function<void(Summary&)> judge;
  };
  struct PlotOf {
    std::string title;
    std::vector<const Source*> signals, references;
  };
  DiagramBuilder& builder_;
  std::vector<const Source*> signals_;
  std::vector<const OutputPort<Geometry>*> shapes_;
  std::vector<PlotOf> plots_;
  std::vector<Judged> judged_;
};

}  // namespace tenon::apps
