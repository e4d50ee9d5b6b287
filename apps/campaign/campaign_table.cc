#include <tenon/apps/campaign/campaign_table.h>

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <set>

#include <tenon/systems/framework/errors.h>

namespace tenon::apps {
namespace {

/// As RFC 4180 has it, on one line.
std::string Quoted(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::replace(text.begin(), text.end(), '\r', ' ');
  if (text.find_first_of(",\"") == text.npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  quoted += '"';
  return quoted;
}

std::string Line(const std::vector<std::string>& cells) {
  std::string line;
  for (const std::string& cell : cells) {
    if (!line.empty()) line += ',';  // the first cell, of the run, is never empty
    line += Quoted(cell);
  }
  line += '\n';
  return line;
}

std::vector<std::string> Cells(std::string_view line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted) {
      if (c != '"') {
        cells.back() += c;
      } else if (i + 1 < line.size() && line[i + 1] == '"') {
        cells.back() += '"';
        ++i;
      } else {
        quoted = false;
      }
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

/// Puts what a row has and the columns lack where it stands in the row: behind its neighbour.
void AddColumns(std::vector<std::string>& columns, const CampaignRow& row) {
  auto at = columns.begin();
  for (const auto& [column, text] : row) {
    auto found = std::find(columns.begin(), columns.end(), column);
    if (found == columns.end()) found = columns.insert(at, column);
    at = found + 1;
  }
}

bool HasAll(const std::vector<std::string>& columns, const CampaignRow& row) {
  return std::ranges::all_of(
      row, [&](const auto& cell) { return std::ranges::find(columns, cell.first) != columns.end(); });
}

std::string LineOf(const CampaignRow& row, const std::vector<std::string>& columns) {
  std::map<std::string_view, std::string_view> texts(row.begin(), row.end());
  std::vector<std::string> cells;
  for (const std::string& column : columns) {
    const auto found = texts.find(column);
    cells.emplace_back(found == texts.end() ? "" : found->second);
  }
  return Line(cells);
}

}  // namespace

std::string_view Cell(const CampaignRow& row, std::string_view column) {
  for (const auto& [name, text] : row)
    if (name == column) return text;
  return {};
}

void CampaignTable::Read(const std::filesystem::path& file,
                         const std::function<void(std::size_t, const CampaignRow&)>& visit) {
  std::ifstream in(file, std::ios::binary);
  std::error_code ignored;
  if (!in || !std::filesystem::is_regular_file(file, ignored))
    throw ParameterError(fmt::format("cannot read '{}': is it the directory of a campaign?", file.string()));
  std::string line;
  const auto next = [&] { return static_cast<bool>(std::getline(in, line)) && !in.eof(); };  // with its end
  if (!next()) return;
  const std::vector<std::string> columns = Cells(line);
  if (columns.size() < 2 || columns[0] != "run")
    throw ParameterError(
        fmt::format("{}:1: not the header of a table of runs, which begins with 'run'; is it "
                    "another file?",
                    file.string()));
  for (long number = 2; next(); ++number) {
    const std::vector<std::string> cells = Cells(line);
    std::size_t run = 0;
    const char* end = cells[0].data() + cells[0].size();
    if (cells.size() != columns.size() || std::from_chars(cells[0].data(), end, run).ptr != end)
      throw ParameterError(fmt::format("{}:{}: {} cells, the header has {}; take the line out, or begin anew",
                                       file.string(), number, cells.size(), columns.size()));
    CampaignRow row;
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (!cells[i].empty()) row.emplace_back(columns[i], cells[i]);
    visit(run, row);
  }
}

CampaignTable::CampaignTable(std::filesystem::path file, Start start) : file_(std::move(file)) {
  if (start == Start::kResume && std::filesystem::exists(file_)) {
    std::vector<std::pair<std::size_t, CampaignRow>> rows;
    Read(file_, [&](std::size_t run, const CampaignRow& row) { rows.emplace_back(run, row); });
    if (!rows.empty()) {
      WriteAnew(std::move(rows));  // without a torn last line
      return;
    }
  }
  out_ = std::make_unique<GrowingFile>(file_);
}

void CampaignTable::Append(std::size_t, const CampaignRow& row) {
  if (!HasAll(columns_, row)) {
    std::vector<std::pair<std::size_t, CampaignRow>> rows;
    if (columns_.empty()) {
      AddColumns(columns_, row);
      out_->Append(Line(columns_));
    } else {
      Read(file_, [&](std::size_t other, const CampaignRow& cells) { rows.emplace_back(other, cells); });
      AddColumns(columns_, row);
      WriteAnew(std::move(rows));
    }
  }
  out_->Append(LineOf(row, columns_));
}

void CampaignTable::WriteAnew(std::vector<std::pair<std::size_t, CampaignRow>> rows) {
  std::vector<std::string> columns = columns_;
  for (const auto& [run, row] : rows) AddColumns(columns, row);
  std::string text = Line(columns);
  for (const auto& [run, row] : rows) text += LineOf(row, columns);
  WriteFile(file_, text);
  columns_ = std::move(columns);
  out_ = std::make_unique<GrowingFile>(file_, GrowingFile::Start::kKeep);
}

void CampaignTable::Finish(const std::function<bool(std::size_t)>& belongs) {
  std::map<std::size_t, CampaignRow> rows;  // by run
  Read(file_, [&](std::size_t run, const CampaignRow& row) {
    if (belongs(run)) rows.emplace(run, row);
  });
  columns_.clear();
  WriteAnew({rows.begin(), rows.end()});
}

}  // namespace tenon::apps
