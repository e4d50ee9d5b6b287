#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tenon/systems/io/output_file.h>

namespace tenon::apps {

/// One run of a campaign: columns and what stands in them, in order. A figure of nothing is "NaN".
using CampaignRow = std::vector<std::pair<std::string, std::string>>;

/// What a row says under a column; empty if it has none of that name.
std::string_view Cell(const CampaignRow& row, std::string_view column);

/// runs.csv: a header and a line for each run, which is there as soon as the run has ended. A cell is empty
/// where a run has no figure of that name. Columns that come up late are put where they belong, by writing
/// the file anew; so the header always names all. No line is ever torn but the last one of a killed writer.
class CampaignTable {
 public:
  enum class Start { kNew, kResume };
  /// Takes over the rows that are there, or none. Throws OutputError; ParameterError if the file is no table
  /// of runs.
  CampaignTable(std::filesystem::path file, Start start);

  /// Adds a run. Throws OutputError; then the file is as it was.
  void Append(std::size_t run, const CampaignRow& row);
  /// Orders the rows by their runs, and columns as the rows say in that order, so that the same rows always
  /// make the same file; leaves out those that do not belong.
  void Finish(const std::function<bool(std::size_t run)>& belongs);

  /// Calls visit(run, row) for every whole line of a table, as they stand. Throws ParameterError if it is
  /// none.
  static void Read(const std::filesystem::path& file,
                   const std::function<void(std::size_t, const CampaignRow&)>& visit);

 private:
  void WriteAnew(std::vector<std::pair<std::size_t, CampaignRow>> rows);

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::unique_ptr<GrowingFile> out_;
};

}  // namespace tenon::apps
