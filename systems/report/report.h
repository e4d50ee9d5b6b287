#pragma once

#include <tenon/systems/geometry.h>
#include <tenon/systems/simulation/simulator.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tenon {

/// One diagram of signals over time.
struct Plot {
  std::string title{};  ///< above the plot
  /// Names as in logs, "cart.x.position"; a name without its elements, "cart.x", stands for all of them.
  std::vector<std::string> signals{};
  /// What the signals should be, drawn dashed: one for each signal, in the same order, or in fewer.
  std::vector<std::string> references{};
  /// Plots that follow one another and have the same group stand under its name, and fold together.
  std::string group{};

  static FieldList Fields() {
    return {Required("title", &Plot::title),
            Required("signals", &Plot::signals),
            {"references", &Plot::references},
            {"group", &Plot::group}};
  }
};

/// What a value should stay within; empty: it has no bound on that side.
struct Limits {
  std::optional<double> low{}, high{};
};

/// Limits of a signal, in its unit: lines in every plot that shows it.
struct SignalLimits {
  std::string signal;  ///< as in Plot::signals
  Limits limits;
};

/// A signal with few values, a mode, that is shown as a band along the time of every plot.
struct Band {
  std::string signal;              ///< one column
  std::vector<std::string> names;  ///< of its values 0, 1, ...

  static FieldList Fields() { return {Required("signal", &Band::signal), Required("names", &Band::names)}; }
};

struct ReportParams {
  std::string title{};
  std::string description{};          ///< one line under the title
  std::vector<Plot> plots{};          ///< none: one for each logged signal and unit
  std::vector<std::string> events{};  ///< names of signals of which every change is marked
  std::vector<Band> bands{};          ///< under one another, the first at the top
  std::vector<SignalLimits> limits{};
  Rate signal_rate = Hz(200);  ///< of what is plotted
  Rate frame_rate = Hz(50);    ///< of the replay; it interpolates between frames

  void Validate() const;  ///< throws ParameterError
};

/// Makes a page to look at a run: title, verdict, table of figures, a 3-D replay of all Geometry ports, and
/// plots, with one time cursor. The page is one file that needs no network.
///
///     Report report({.title = "cart"});
///     report.Log(simulator, {&cart.state, &pd.u}, {&cart.geometry});
///     simulator.RunTo(10);
///     report.Write("report.html");
///
/// All signals that are logged can be chosen in the page; those of `plots` are shown at once and kept finer.
///
/// Several runs in one page, over each other in the plots and side by side in the table: a Report for each,
/// and one more to which they are added.
///
///     Report comparison({.title = "cart", .plots = plots});
///     comparison.Add("soft", soft);
///     comparison.Add("stiff", stiff);
///     comparison.Write("comparison.html");
///
/// Plots keep the first, the smallest and the largest sample of every short interval, so that no peak is
/// lost; columns of the replay that never change are stored once; a page stays below 10 MB. The page draws
/// with three.js and Dygraphs, which are read from where Debian installs them (libjs-three, libjs-dygraphs;
/// another directory than /usr/share/javascript can be given in the environment variable
/// TENON_JAVASCRIPT_DIR) and copied into it.
class Report {
 public:
  /// Throws RunError that names the package to install if three.js or Dygraphs is not there, and
  /// ParameterError for a plot without signals: now, not after a long run.
  explicit Report(ReportParams params);
  /// The report of a run that has ended, from the directory that it wrote report.html and signals.csv into:
  /// with all its samples, so that it can be added to others. Throws ParameterError that names the directory
  /// and what is missing or wrong there.
  static Report Read(const std::filesystem::path& directory);
  ~Report();
  Report(Report&&) noexcept;

  /// Adds logs to the simulator; call it before the run, once. Geometry may come from several blocks. Throws
  /// ParameterError with the nearest name if a plot names a signal that is not among `signals`.
  void Log(Simulator& simulator, const std::vector<const Source*>& signals,
           const std::vector<const OutputPort<Geometry>*>& geometry = {});

  /// A row of the table; an empty value is shown as a dash, one beyond its limits in red. Units belong into
  /// the name: "error_max_m", "foot_error_max_m.rear_left"; small lengths are shown in mm, angles in degrees.
  void AddFigure(const std::string& name, std::optional<double> value, const Limits& limits = {});
  void AddFigure(const std::string& name, const std::string& text);
  /// A mark in all plots.
  void AddEvent(double time, const std::string& label);
  /// The verdict: what came out, and whether that is what was asked for.
  void Conclude(bool good, const std::string& verdict);
  /// The same from how the run ended; a monitor that ended it gives the reason and an event.
  void Conclude(const RunStatus& status);

  /// Takes over the run of another report, under the name of a variant. Later changes of that are seen.
  void Add(const std::string& variant, const Report& other);

  /// As a whole, see WriteFile. Throws OutputError if the file cannot be written, RunError if there is
  /// nothing to show.
  void Write(const std::filesystem::path& file) const;

  const ReportParams& params() const { return params_; }

 private:
  struct Run;
  struct Variant {
    std::string name;
    std::shared_ptr<Run> run;
  };
  Run& own();
  ReportParams params_;
  std::vector<Variant> variants_;
};

}  // namespace tenon
