#pragma once

#include <tenon/systems/files/output_file.h>

#include <cstdint>
#include <functional>
#include <ios>
#include <memory>
#include <vector>

namespace tenon::apps {

class CampaignPlan;

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

}  // namespace tenon::apps
