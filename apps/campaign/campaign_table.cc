#include <tenon/apps/campaign/campaign_runner.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>

#include <cctype>

namespace tenon::apps {
namespace {

/// Quotes a cell as in RFC 4180, on one line.
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
    if (!line.empty()) line += ',';  // the first cell holds the run and is never empty
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

/// Inserts columns of a row that are missing, each after its predecessor in the row.
void AddColumns(std::vector<std::string>& columns, const CampaignRow& row) {
  auto at = columns.begin();
  for (const auto& [column, text] : row) {
    auto found = std::find(columns.begin(), columns.end(), column);
    if (found == columns.end()) found = columns.insert(at, column);
    at = found + 1;
  }
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

/// Reads the lines of a table in order or at given offsets.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& file) : file_(file), in_(OpenInput(file, std::ios::binary)) {
    if (!in_.is_open())
      throw ParameterError(fmt::format(
          "cannot read '{}'; check that this is the output directory of a campaign", file.string()));
    if (!Next()) return;                                       // empty, or an incomplete header
    if (line_.starts_with("\xEF\xBB\xBF")) line_.erase(0, 3);  // a byte-order mark
    columns_ = Cells(line_);
    if (columns_.size() < 2 || columns_[0] != "run")
      throw ParameterError(fmt::format(
          "{}:1: the header of a table of runs must begin with 'run'; check the file", file.string()));
  }
  const std::vector<std::string>& columns() const { return columns_; }
  /// Offset of the next line [bytes].
  std::streamoff at() const { return end_; }
  /// Reads the next complete line. Returns false at the end.
  bool Next() {
    ++number_;
    if (!std::getline(in_, line_) || in_.eof()) return false;
    end_ += static_cast<std::streamoff>(line_.size()) + 1;
    RemoveReturn();
    return true;
  }
  void GoTo(std::streamoff at) {
    in_.clear();
    in_.seekg(at);
    std::getline(in_, line_);
    RemoveReturn();
  }
  std::string place() const { return fmt::format("{}:{}", file_.string(), number_); }
  std::pair<std::size_t, CampaignRow> Row() const {
    std::vector<std::string> cells = Cells(line_);
    const auto run = internal::NumberIn<std::size_t>(cells[0]);
    if (cells.size() != columns_.size() || !run)
      throw ParameterError(fmt::format(
          "{}:{}: the line must have {} cells and begin with the number of a run; remove it, or restart "
          "the campaign",
          file_.string(), number_, columns_.size()));
    CampaignRow row;
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (!cells[i].empty()) row.emplace_back(columns_[i], std::move(cells[i]));
    return {*run, std::move(row)};
  }

 private:
  /// Removes the carriage return that a spreadsheet writes at the end of a line.
  void RemoveReturn() {
    if (line_.ends_with('\r')) line_.pop_back();
  }
  std::filesystem::path file_;
  std::ifstream in_;
  std::string line_;
  std::vector<std::string> columns_;
  std::streamoff end_ = 0;
  long number_ = 0;
};

/// Returns whether a text is a word in small letters, in any case.
bool IsWord(std::string_view text, std::string_view word) {
  return std::ranges::equal(text, word, {}, [](unsigned char c) { return std::tolower(c); });
}

/// Visits the complete lines of a table with runs 0 to runs - 1.
void VisitRows(const std::filesystem::path& file, std::size_t runs,
               const std::function<void(const Lines&, std::size_t, const CampaignRow&)>& visit) {
  Lines lines(file);
  while (!lines.columns().empty() && lines.Next()) {
    const auto [run, row] = lines.Row();
    if (run >= runs)
      throw ParameterError(fmt::format(
          "{}: run {} is out of range: this campaign has runs 0 to {}; check that the table belongs to it",
          lines.place(), run, runs - 1));
    visit(lines, run, row);
  }
}

}  // namespace

std::string_view Cell(const CampaignRow& row, std::string_view column) {
  for (const auto& [name, text] : row)
    if (name == column) return text;
  return {};
}

bool DependsOnMachine(std::string_view column) {
  return column == "tenon" || std::ranges::any_of(std::array{"wall", "qp_time", "mpc_time", "real_time"},
                                                  [&](const char* part) { return column.starts_with(part); });
}

std::uint64_t HashOfResults(const CampaignRow& row) {
  std::uint64_t sum = 0;
  for (const auto& [column, text] : row) {
    if (DependsOnMachine(column)) continue;
    internal::Fnv1a hash;
    hash.Add(column + '\n' + text);
    sum += hash.value();
  }
  return sum;
}

void CampaignTable::Read(const std::filesystem::path& file, std::size_t runs,
                         const std::function<void(std::size_t, const CampaignRow&)>& visit) {
  VisitRows(file, runs, [&](const Lines&, std::size_t run, const CampaignRow& row) { visit(run, row); });
}

void CampaignTable::Read(const std::filesystem::path& file, const CampaignPlan& plan,
                         const std::function<void(std::size_t, const CampaignRow&)>& visit) {
  std::unordered_map<std::size_t, std::uint64_t> results;
  VisitRows(file, plan.size(), [&](const Lines& lines, std::size_t run, const CampaignRow& row) {
    const auto fail = [&](const std::string& why) {
      throw ParameterError(
          fmt::format("{}: run {}: {}; remove the line and continue with --resume, or restore "
                      "the table that the campaign wrote",
                      lines.place(), run, why));
    };
    if (const std::string_view text = Cell(row, "finished"); text != "true" && text != "false")
      fail(fmt::format("finished is '{}' instead of true or false", internal::Excerpt(std::string(text))));
    for (const auto& [column, text] : row)
      if (text != "true" && text != "false" && (IsWord(text, "true") || IsWord(text, "false")))
        fail(fmt::format("{} is '{}' instead of true or false", column, text));  // of a spreadsheet
    const std::string seed = fmt::format("{}", plan.file().seeds.first + run % plan.num_seeds());
    if (Cell(row, "seed") != seed)
      fail(fmt::format("the seed is '{}' instead of {}", internal::Excerpt(std::string(Cell(row, "seed"))),
                       seed));
    const auto [known, is_new] = results.emplace(run, HashOfResults(row));
    if (!is_new && known->second != HashOfResults(row))
      fail("an earlier line has another result of the same run");
    visit(run, row);
  });
}

CampaignTable::CampaignTable(std::filesystem::path file, Start start) : file_(std::move(file)) {
  if (start == Start::kResume && std::filesystem::exists(file_)) {
    Lines lines(file_);
    if (!lines.columns().empty()) {
      columns_ = lines.columns();
      while (lines.Next()) {
      }
      std::error_code error;
      std::filesystem::resize_file(file_, static_cast<std::uintmax_t>(lines.at()), error);
      if (error) throw OutputError(fmt::format("cannot write '{}': {}", file_.string(), error.message()));
      out_ = std::make_unique<GrowingFile>(file_, GrowingFile::Start::kKeep);
      return;
    }
  }
  out_ = std::make_unique<GrowingFile>(file_);
}

void CampaignTable::Append(const CampaignRow& row) {
  std::vector<std::string> columns = columns_;
  AddColumns(columns, row);
  if (columns_.empty()) {
    out_->Append(Line(columns));
    columns_ = std::move(columns);
  } else if (columns.size() > columns_.size()) {
    std::vector<std::streamoff> places;
    Lines lines(file_);
    for (std::streamoff at = lines.at(); lines.Next(); at = lines.at()) places.push_back(at);
    Rewrite(places, std::move(columns));
  }
  out_->Append(LineOf(row, columns_));
}

void CampaignTable::Rewrite(const std::vector<std::streamoff>& places, std::vector<std::string> columns) {
  std::filesystem::path part = file_;
  part += ".part";
  std::error_code error;
  try {
    Lines lines(file_);
    GrowingFile anew(part);
    std::string text = columns.empty() ? "" : Line(columns);
    for (const std::streamoff at : places) {
      lines.GoTo(at);
      text += LineOf(lines.Row().second, columns);
      if (text.size() < (1 << 20)) continue;
      anew.Append(text);
      text.clear();
    }
    anew.Append(text);
    anew.Sync();  // must be on disk before it replaces the table
  } catch (...) {
    std::filesystem::remove(part, error);
    throw;
  }
  std::filesystem::rename(part, file_, error);
  if (error) throw OutputError(fmt::format("cannot write '{}': {}", file_.string(), error.message()));
  columns_ = std::move(columns);
  out_ = std::make_unique<GrowingFile>(file_, GrowingFile::Start::kKeep);
}

void CampaignTable::Finish(const std::function<bool(std::size_t)>& belongs) {
  std::map<std::size_t, std::streamoff> places;  // by run
  Lines lines(file_);
  for (std::streamoff at = lines.at(); !lines.columns().empty() && lines.Next(); at = lines.at())
    if (const std::size_t run = lines.Row().first; belongs(run)) places.emplace(run, at);
  std::vector<std::string> columns;
  std::vector<std::streamoff> order;
  for (const auto& [run, at] : places) {
    lines.GoTo(at);
    AddColumns(columns, lines.Row().second);
    order.push_back(at);
  }
  Rewrite(order, std::move(columns));
}

}  // namespace tenon::apps
