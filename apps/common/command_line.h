#pragma once

#include <tenon/apps/common/scenario_app.h>

#include <variant>

namespace CLI {
class App;
}

namespace tenon::apps {

/// Range of a number on the command line.
enum class OptionRange { kAny, kPositive, kNotNegative, kPositiveInteger, kSeed, kPort };

/// Traits of an option of a command line.
struct OptionTraits {
  OptionRange range = OptionRange::kAny;
  const char* type = nullptr;  ///< placeholder of the value in the help; null: that of its C++ type
  int count = 0;               ///< number of values, for lists; 0: any
  bool required = false;
  bool one_value_each = false;     ///< a list receives one value each time that the option is given
  bool shows_default = false;      ///< the help shows the value of the variable
  const char* needs = nullptr;     ///< option that must be given, too
  const char* excludes = nullptr;  ///< option that must not be given, too
};

/// The options of a program, which RunMain reads from its command line into variables.
class CommandLine {
 public:
  using Variable =
      std::variant<bool*, int*, double*, std::string*, std::vector<double>*, std::vector<std::string>*,
                   std::optional<double>*, std::optional<std::uint64_t>*,
                   std::optional<std::pair<double, std::string>>*>;

  CommandLine(const std::string& description, const std::string& name);
  ~CommandLine();

  /// Adds an option, or a positional argument if the name has no dashes. A bool is a flag. `--name{value}` is
  /// a flag with a value, which is `value` if none is given.
  void Add(const std::string& name, Variable variable, const std::string& help,
           const OptionTraits& traits = {});
  /// Sets the text below the options in the help.
  void SetFooter(const std::string& text);
  /// Returns whether the command line had this option.
  bool Has(const std::string& name) const;

 private:
  friend int RunMain(CommandLine& line, int argc, char** argv, const std::function<int()>& body);

  std::unique_ptr<CLI::App> app_;
};

/// The command-line arguments that all apps share.
struct CommonArguments {
  std::string scenario;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> settings;  ///< key=value
  std::optional<double> duration;     ///< [s]
  std::string out;                    ///< output directory; empty: out/SCENARIO
  std::string graph;                  ///< file of the diagram's graph; empty: none
  std::string live;                   ///< port; empty: not live
  std::string live_address;           ///< address to listen at; empty: this machine only
  std::string replay;                 ///< recording of a live run; empty: none
  std::string ros2;                   ///< see RunOptions; empty: none
  bool mcap = false;                  ///< see RunOptions
  std::string figure;                 ///< number of a figure, or kListFigures; empty: none
  bool list = false;
  bool keys = false;
};

/// Adds the arguments that select a scenario to an app's command line.
void AddScenarioArguments(CommandLine& line, CommonArguments& arguments);

/// Adds the arguments of an app that runs one scenario, with --figure if the app has `figures`.
void AddAppArguments(CommandLine& line, const ScenarioApp& app, CommonArguments& arguments);

/// Returns the output directory, --out or out/SCENARIO, and the file of --graph.
RunOptions OptionsOf(const CommonArguments& arguments);

/// Parses the command line, runs `body`, and turns errors into a message on stderr and an exit code.
int RunMain(CommandLine& line, int argc, char** argv, const std::function<int()>& body);

/// The file name of the program.
std::string ProgramName(char** argv);

/// Loads the scenario of a command line and draws its random values by the seed.
YamlDocument LoadScenario(const CommonArguments& arguments, const std::string& app);

/// Calls `run` with the arguments and the options of the command line once, and with --live once more for
/// each reset, which changes the seed. A replay uses the seed of the recording. Returns the last exit code.
int RunLive(CommonArguments arguments,
            const std::function<int(const CommonArguments& arguments, const RunOptions& options)>& run);

/// Prints the list of --list or --keys. Returns whether the command line has one of them.
bool PrintsInstead(const CommonArguments& arguments, const ScenarioApp& app);

/// Runs the command lines that all apps share: prints a list, makes a figure, or returns nothing.
std::optional<int> RunInstead(const CommonArguments& arguments, const ScenarioApp& app);

/// Value of --figure that stands for the list of all figures.
inline constexpr const char* kListFigures = "list";

/// One of several runs that a figure compares.
struct FigureRun {
  std::string name;
  std::string scenario;          ///< empty: that of the figure
  std::vector<std::string> set;  ///< changes to the scenario, as for --set

  static FieldList Fields() {
    return {Required("name", &FigureRun::name), {"scenario", &FigureRun::scenario}, {"set", &FigureRun::set}};
  }
};

/// A figure of the thesis: a scenario, and the plots or the picture that show it.
struct ThesisFigure {
  std::string number;  ///< number in the thesis, "2.5"
  std::string app;     ///< app of its scenario
  std::string title;
  std::string thesis;  ///< result that the thesis reports
  std::string scenario;
  std::vector<std::string> set;    ///< changes to the scenario, as for --set
  std::vector<FigureRun> runs;     ///< compared runs; empty: one run
  std::vector<Plot> plots;         ///< contents of the report
  std::vector<double> pictures_s;  ///< times of pictures of the replay

  static FieldList Fields() {
    return {Required("number", &ThesisFigure::number),
            Required("app", &ThesisFigure::app),
            Required("title", &ThesisFigure::title),
            Required("thesis", &ThesisFigure::thesis),
            Required("scenario", &ThesisFigure::scenario),
            {"set", &ThesisFigure::set},
            {"runs", &ThesisFigure::runs},
            {"plots", &ThesisFigure::plots},
            Field("pictures_s", &ThesisFigure::pictures_s).AtLeast(0)};
  }
};

/// Reads a shipped list of figures, or a file. Throws ParameterError.
std::vector<ThesisFigure> LoadFigures(const std::string& name);

/// Lists the figures of an app, or runs the scenario of the figure that the command line names and saves its
/// plots and pictures as files, if Chromium is installed, beside the report. Returns the exit code of the
/// runs. Throws ParameterError with the list for an unknown number.
int RunFigure(const ScenarioApp& app, const CommonArguments& arguments);

}  // namespace tenon::apps
