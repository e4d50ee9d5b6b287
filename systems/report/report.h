#pragma once

#include <tenon/systems/geometry.h>
#include <tenon/systems/simulation/simulator.h>

namespace tenon {

/// One diagram of signals over time.
///
/// Three prefixes derive curves from logged signals. `norm:NAME` is the Euclidean norm of the elements of
/// NAME. `rate:NAME` is the rate of change of each element from one row of the log to the next. `xy:NAME` is
/// a path: the second element of NAME over the first, with equal scales. The signals and references of a plot
/// are either all paths or none.
struct Plot {
  std::string title{};  ///< title above the plot
  /// Names as in logs, "cart.x.position"; "cart.x" stands for all elements of the signal. See the prefixes.
  std::vector<std::string> signals{};
  /// References of the signals in the same order, drawn dashed; there may be fewer than signals.
  std::vector<std::string> references{};
  /// Consecutive plots of the same group are shown under its name and fold together.
  std::string group{};

  static FieldList Fields() {
    return {Required("title", &Plot::title),
            Required("signals", &Plot::signals),
            {"references", &Plot::references},
            {"group", &Plot::group}};
  }
};

/// The logged signal of a name in a plot: the name without `norm:`, `rate:` or `xy:`.
std::string_view LoggedName(std::string_view name);

/// Bounds of a value; an empty bound is not checked.
struct Limits {
  std::optional<double> low{}, high{};
};

/// Limits of a signal in its unit, drawn as lines in every plot that shows it.
struct SignalLimits {
  std::string signal;  ///< name as in Plot::signals
  Limits limits;
};

/// A signal with few values, such as a mode, that every plot shows as a band along the time axis.
struct Band {
  std::string signal;              ///< name of one column
  std::vector<std::string> names;  ///< names of the values 0, 1, ...

  static FieldList Fields() { return {Required("signal", &Band::signal), Required("names", &Band::names)}; }
};

struct ReportParams {
  std::string title{};
  std::string description{};          ///< one line under the title
  std::vector<Plot> plots{};          ///< default: one plot for each logged signal and unit
  std::vector<std::string> events{};  ///< names of signals whose changes are marked
  std::vector<Band> bands{};          ///< bands from top to bottom
  std::vector<SignalLimits> limits{};
  Rate signal_rate = Hz(200);  ///< rate of plotted signals
  Rate frame_rate = Hz(50);    ///< rate of the replay, which interpolates between frames

  void Validate() const;  ///< throws ParameterError
};

/// A page that shows a run: title, verdict, table of figures, a 3-D replay of all Geometry ports, and plots
/// with a common time cursor. The page is one file that needs no network.
///
///     Report report({.title = "cart"});
///     report.Log(simulator, {&cart.state, &pd.u}, {&cart.geometry});
///     simulator.RunTo(10);
///     report.Write("report.html");
///
/// Any logged signal can be selected in the page; those of `plots` are shown initially and with finer
/// resolution.
///
/// To compare several runs, overlaid in the plots and side by side in the table, make a Report for each run
/// and add them to another one:
///
///     Report comparison({.title = "cart", .plots = plots});
///     comparison.Add("soft", soft);
///     comparison.Add("stiff", stiff);
///     comparison.Write("comparison.html");
///
/// Plots keep the first, smallest and largest sample of every short interval, so that no peak is lost.
/// Constant columns of the replay are stored once. A page stays below 10 MB. It contains copies of three.js
/// and Dygraphs, which are read from /usr/share/javascript (Debian's libjs-three and libjs-dygraphs) or the
/// directory in the environment variable TENON_JAVASCRIPT_DIR.
class Report {
 public:
  /// Throws RunError with the package to install if three.js or Dygraphs is missing, and ParameterError for a
  /// plot without signals, or with paths and other signals.
  explicit Report(ReportParams params);
  /// Reads the report of a completed run from report.html and signals.csv in its output directory, with all
  /// samples, so that it can be added to other reports. Throws ParameterError that names the directory and
  /// the error.
  static Report Read(const std::filesystem::path& directory);
  ~Report();
  Report(Report&&) noexcept;

  /// Adds logs to the simulator. Call it once before the run. `shapes` may belong to several blocks. Throws
  /// ParameterError with the nearest name if a plot names a signal that is not in `signals`.
  void Log(Simulator& simulator, const std::vector<const Source*>& signals,
           const std::vector<const OutputPort<Geometry>*>& geometry = {});

  /// Adds a row to the table. An empty value is shown as a dash, and a value beyond its limits in red. The
  /// name contains the unit: "error_max_m", "foot_error_max_m.rear_left". Small lengths are shown in mm,
  /// angles in degrees.
  void AddFigure(const std::string& name, std::optional<double> value, const Limits& limits = {});
  void AddFigure(const std::string& name, const std::string& text);
  /// Adds a mark to all plots.
  void AddEvent(double time, const std::string& label);
  /// Sets the verdict: the outcome and whether it is good.
  void Conclude(bool good, const std::string& verdict);
  /// Sets the verdict from the end of the run; a monitor that ended it provides the reason and an event.
  void Conclude(const RunStatus& status);

  /// Adds the run of another report under the name of a variant. The run is shared, not copied.
  void Add(const std::string& variant, const Report& other);

  /// Writes the page by WriteFile. Throws OutputError if the file cannot be written, and RunError if the
  /// report is empty.
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
