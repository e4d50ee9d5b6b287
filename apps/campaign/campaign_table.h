#pragma once

#include <tenon/systems/files/output_file.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <ios>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tenon::apps {

/// One run of a campaign: columns and what stands in them, in order.
using CampaignRow = std::vector<std::pair<std::string, std::string>>;

/// What a row says under a column; empty if it has none of that name.
std::string_view Cell(const CampaignRow& row, std::string_view column);

/// runs.csv: a header and a line for each run, which is there as soon as the run has ended. A cell is empty
/// where a run has no figure of that name, "NaN" where the figure is of nothing. Columns that come up late
/// are put where they belong, by writing the file anew; so the header always names all. No line is ever torn
/// but the last one of a killed writer. Rows are not kept in memory.
class CampaignTable {
 public:
  enum class Start { kNew, kResume };
  /// Takes over the rows that are there, but for a torn line, or none. Throws OutputError; ParameterError if
  /// the file is no table of runs.
  CampaignTable(std::filesystem::path file, Start start);

  /// Adds a run. Throws OutputError; then the run is not in it, and all others are.
  void Append(const CampaignRow& row);
  /// Orders the rows by their runs, and columns as the rows say in that order, so that the same rows always
  /// make the same file; leaves out those that do not belong, and what is there twice.
  void Finish(const std::function<bool(std::size_t run)>& belongs);

  /// Calls visit(run, row) for every whole line of a table, as they stand. Throws ParameterError if it is
  /// none, or has a run that is not below `runs`.
  static void Read(const std::filesystem::path& file, std::size_t runs,
                   const std::function<void(std::size_t, const CampaignRow&)>& visit);

 private:
  void Rewrite(const std::vector<std::streamoff>& lines, std::vector<std::string> columns);

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::unique_ptr<GrowingFile> out_;
};

}  // namespace tenon::apps
