#pragma once

#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/apps/common/scenario_app.h>

#include <ios>

namespace tenon::apps {

/// One run of a campaign: names and texts of its columns, in order.
using CampaignRow = std::vector<std::pair<std::string, std::string>>;

/// Returns the text of a column; empty if the row has no such column.
std::string_view Cell(const CampaignRow& row, std::string_view column);

/// Returns whether a column holds measured times or the version of Tenon, which differ when a run is
/// repeated.
bool DependsOnMachine(std::string_view column);
/// Returns a hash of the results of a run. It does not depend on such columns and on the order of columns.
std::uint64_t HashOfResults(const CampaignRow& row);

/// The file runs.csv: a header and a line for each run, written when the run ends. A cell is empty if the run
/// has no such figure, "null" if the figure has no value, and "NaN" if its computation failed. When a run has
/// new columns, the file is rewritten with these columns in their order. Only the last line of a killed
/// process can be incomplete. Rows are not kept in memory.
class CampaignTable {
 public:
  enum class Start { kNew, kResume };
  /// Opens the file. kResume keeps all complete lines. Throws OutputError, and ParameterError if the file is
  /// not a table of runs.
  CampaignTable(std::filesystem::path file, Start start);

  /// Adds a run. If it throws OutputError, the table is unchanged.
  void Append(const CampaignRow& row);
  /// Sorts the rows by run and the columns by their order in these rows, so that equal rows give equal files.
  /// Removes duplicates and runs for which `belongs` is false.
  void Finish(const std::function<bool(std::size_t run)>& belongs);

  /// Calls visit(run, row) for every complete line of a table. Throws ParameterError if the file is not a
  /// table of runs or contains a run that is not below `runs`.
  static void Read(const std::filesystem::path& file, std::size_t runs,
                   const std::function<void(std::size_t, const CampaignRow&)>& visit);
  /// Reads a table of the campaign `plan`. Throws ParameterError with the line also if `finished` is
  /// neither true nor false, if a spreadsheet has changed such a word in another column, if the seed is not
  /// that of the plan, and if two lines give different results of the same run.
  static void Read(const std::filesystem::path& file, const CampaignPlan& plan,
                   const std::function<void(std::size_t, const CampaignRow&)>& visit);

 private:
  void Rewrite(const std::vector<std::streamoff>& lines, std::vector<std::string> columns);

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::unique_ptr<GrowingFile> out_;
};

/// The result of a run.
struct CampaignResult {
  CampaignRow row;
  bool survived = false;  ///< the run reached its end
  int exit_code = 0;      ///< ExitCode of the app
  /// Why the machine could not complete the run: a full disk, lack of memory, a missing program. Empty if it
  /// could. Such a run says nothing about the robot and has no row.
  std::string machine_failure{};
};

/// Executes runs of a plan and returns their rows. It is immutable and thread-safe.
class CampaignRunner {
 public:
  /// Reads all scenarios and checks the first run of at most a hundred points. If none of these can run,
  /// throws ParameterError with the place of the invalid key in the campaign's file.
  CampaignRunner(const CampaignPlan& plan, const YamlDocument& file, ScenarioApp app);

  /// Executes a run. An exception becomes a row with its message, or a failure of the machine. Empty if a
  /// signal stopped the run.
  std::optional<CampaignResult> Run(std::size_t run) const;
  /// Executes a run with all outputs in a directory and does not catch exceptions.
  CampaignResult Replay(std::size_t run, const std::filesystem::path& out) const;
  /// Returns the columns that are known before the run.
  CampaignRow Begin(std::size_t run) const;
  const ScenarioApp& app() const { return app_; }
  /// Numbers of checked and of refused points, and the reason of the first refusal.
  std::size_t num_checked() const { return num_checked_; }
  std::size_t num_refused() const { return num_refused_; }
  const std::string& refusal() const { return refusal_; }
  /// The error if the scenario of the first valid point does not accept the campaign's `duration_s`, for
  /// example because its figures begin later; else empty.
  const std::string& cut_short() const { return cut_short_; }
  /// Returns all scenarios as text, for comparison.
  std::string ScenarioTexts() const;

 private:
  struct Prepared {
    YamlDocument scenario;
    CampaignRow row;
  };
  Prepared Prepare(std::size_t run) const;

  const CampaignPlan& plan_;
  ScenarioApp app_;
  std::map<std::string, YamlDocument> scenarios_;
  std::size_t num_checked_ = 0, num_refused_ = 0;
  std::string refusal_, cut_short_;
};

/// Makes an app of a separate program whose main function calls RunApp. Each run is a process, and its
/// figures are read from its summary.json. The program itself refuses scenarios of other apps. Throws
/// ParameterError if it is not executable.
ScenarioApp ProgramApp(const std::filesystem::path& program);

}  // namespace tenon::apps
