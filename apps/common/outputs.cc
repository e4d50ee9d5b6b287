#include <tenon/apps/common/beside.h>
#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/common/memory_reserve.h>
#include <tenon/apps/common/number_or_null.h>
#include <tenon/apps/common/outputs.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/simulation/background_log.h>
#include <tenon/systems/text/nearest_name.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

namespace tenon::apps {

namespace fs = std::filesystem;

OutputLock::OutputLock(fs::path path) : path_(std::move(path)) {
  std::error_code error;
  fs::create_directories(path_, error);
  lock_ = error ? -1 : ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) {
    throw OutputError(fmt::format("cannot make the output directory '{}' ({}): choose another --out",
                                  path_.string(), error ? error.message() : std::strerror(errno)));
  }
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(lock_);
    throw ParameterError(
        fmt::format("another run writes into the output directory '{}': wait for it, or choose another --out",
                    path_.string()));
  }
}

OutputLock::~OutputLock() {
  ::close(lock_);
}

namespace {

/// The names of the variants that a run of several left in a directory.
std::vector<std::string> VariantsIn(const fs::path& directory) {
  std::ifstream in(directory / "summary.json");
  const auto summary = nlohmann::json::parse(in, nullptr, false);
  std::vector<std::string> names;
  if (!summary.is_object()) return names;
  for (const auto& [name, figures] : summary.items())
    if (figures.is_object() && figures.contains("end_reason") && IsVariantName(name)) names.push_back(name);
  return names;
}

}  // namespace

bool IsVariantName(std::string_view name) {
  constexpr std::size_t kLongest = 200;  // bytes; file systems take 255
  return !name.empty() && name.size() <= kLongest && name.front() != '.' &&
         name.find_first_of(std::string_view("/\0", 2)) == name.npos;
}

OutputDirectory::OutputDirectory(fs::path path) : OutputLock(std::move(path)) {
  std::error_code error;
  for (const std::string& variant : VariantsIn(this->path())) {
    const fs::path directory = this->path() / variant;
    if (!fs::is_directory(directory, error)) continue;
    OutputDirectory{directory};
    fs::remove(directory, error);  // unless there is more in it
  }
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(this->path(), error)) {
    const std::string file = entry.path().filename().string();
    for (const std::string name : {"scenario.yaml", "signals.csv", "summary.json", "report.html"})
      if (file == name || (file.starts_with("." + name + ".") && file.ends_with(".part")))  // of a killed run
        left.push_back(entry.path());
  }
  for (const fs::path& file : left) fs::remove(file, error);
}

namespace {

/// Runs Graphviz's dot, without a shell. Returns its exit code; nothing if there is none.
std::optional<int> RunDot(const fs::path& text, const fs::path& svg) {
  std::string arguments[] = {"dot", "-Tsvg", "-o", svg.string(), text.string()};
  char* list[] = {arguments[0].data(), arguments[1].data(), arguments[2].data(),
                  arguments[3].data(), arguments[4].data(), nullptr};
  ::pid_t process = 0;
  const int error = ::posix_spawnp(&process, "dot", nullptr, nullptr, list, environ);
  if (error == ENOENT) return {};
  if (error != 0) throw OutputError(fmt::format("cannot run Graphviz's `dot`: {}", std::strerror(error)));
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

void WriteGraph(const Diagram& diagram, const fs::path& file) {
  if (file.empty()) return;
  if (file.extension() == ".dot") return WriteFile(file, diagram.Graphviz());
  if (file.extension() != ".svg") {
    throw ParameterError(fmt::format("--graph {}: name a file that ends in .svg or .dot", file.string()));
  }
  const fs::path svg = fs::absolute(file);
  const auto part = [&](const char* ending) {
    return fs::path(svg).replace_filename(
        fmt::format(".{}.{}{}.part", svg.filename().string(), ::getpid(), ending));
  };
  const fs::path text = part(".dot"), drawn = part("");
  try {
    WriteFile(text, diagram.Graphviz());
  } catch (const OutputError& failure) {
    throw OutputError(fmt::format("--graph {}: {}", file.string(), failure.what()));
  }
  const std::optional<int> code = RunDot(text, drawn);
  std::error_code error, ignored;
  fs::remove(text, ignored);
  if (code == 0) fs::rename(drawn, svg, error);
  if (code != 0 || error) fs::remove(drawn, ignored);
  if (!code)
    throw ParameterError(fmt::format(
        "--graph {}: there is no `dot`; apt-get install graphviz, or write a .dot file", file.string()));
  if (*code != 0)
    throw OutputError(fmt::format(
        "cannot write '{}': Graphviz's `dot` ended with {}; is the disk full? A .dot file takes less",
        file.string(), *code));
  if (error) throw OutputError(fmt::format("cannot write '{}': {}", file.string(), error.message()));
}

void ReportScenario::Validate() const {
  static constexpr std::size_t kMost = 1000;  // a page of more can neither be read nor shown
  const auto demand = [](std::size_t count, const std::string& what) {
    if (count > kMost)
      throw ParameterError(fmt::format("{} has {} entries: {} are the most", what, count, kMost));
  };
  demand(plots.size(), "plots");
  demand(events.size(), "events");
  demand(bands.size(), "bands");
  for (std::size_t i = 0; i < plots.size(); ++i) {
    demand(plots[i].signals.size(), fmt::format("plots.{}.signals", i));
    demand(plots[i].references.size(), fmt::format("plots.{}.references", i));
  }
}

/// What a Monitor is called that knows when a robot has fallen.
static constexpr const char* kFall = "fall";

struct Summary::Json {
  nlohmann::ordered_json values;
};

Summary::Summary(const std::string& case_name, std::uint64_t seed, const RunOutcome& outcome)
    : json_(std::make_unique<Json>()) {
  const bool failed = !outcome.failure.empty();
  exit_code_ = outcome.exit_code;
  auto& values = json_->values;
  values["case"] = case_name;
  values["seed"] = seed;
  values["finished"] = exit_code_ == kRan;
  values["fell"] = outcome.status.monitor != nullptr && outcome.status.monitor->name() == kFall;
  values["end_reason"] = failed                 ? outcome.failure
                         : outcome.status.ended ? outcome.status.reason
                                                : "end of the run";
  values["simulated_s"] = outcome.status.time;
  values["wall_s"] = outcome.wall_s;
  values["real_time_factor"] = outcome.wall_s > 0 ? outcome.status.time / outcome.wall_s : 0;
}

Summary::Summary(std::unique_ptr<Json> json, int exit_code) : json_(std::move(json)), exit_code_(exit_code) {}

namespace {

constexpr const char *kLimits = "limits", *kNotes = "notes";

std::optional<double> NumberIn(const nlohmann::ordered_json& object, const char* key) {
  if (!object.contains(key)) return std::nullopt;
  return object[key].get<double>();
}

}  // namespace

Summary Summary::Load(const fs::path& file, int exit_code) {
  std::ifstream in(file);
  auto json = std::make_unique<Json>();
  json->values = nlohmann::ordered_json::parse(in, nullptr, false);
  if (!json->values.is_object() || !json->values.contains("finished") ||
      !json->values["finished"].is_boolean())
    throw RunError(
        fmt::format("'{}' holds no figures of a run: did something else write it?", file.string()));
  Summary summary(std::move(json), exit_code);
  auto& values = summary.json_->values;
  const auto limits = values.value(kLimits, nlohmann::ordered_json::object());
  for (const auto& [key, limit] : limits.items())
    summary.Limit(key, {NumberIn(limit, "low"), NumberIn(limit, "high")});
  values.erase(kLimits);
  for (const auto& note : values.value(kNotes, nlohmann::ordered_json::array())) summary.Note(note);
  values.erase(kNotes);
  return summary;
}

Summary::Summary(Summary&&) noexcept = default;
Summary::~Summary() = default;

void Summary::Set(const std::string& key, std::optional<double> value) {
  json_->values[key] = NumberOrNull(value);
}
void Summary::Set(const std::string& key, const std::string& value) {
  json_->values[key] = value;
}
void Summary::Set(const std::string& key,
                  const std::vector<std::pair<std::string, std::optional<double>>>& values) {
  auto& object = json_->values[key] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : values) object[name] = NumberOrNull(value);
}

void Summary::SetFollowed(std::optional<bool> followed) {
  auto& value = json_->values["followed"];
  if (followed) value = *followed;
}

void Summary::Break(double time, const std::string& reason) {
  const auto later = std::ranges::find_if(breaches_, [&](const auto& other) { return other.first > time; });
  breaches_.emplace(later, time, reason);
  if (exit_code_ != kRan && !judged_) return;
  judged_ = true;
  exit_code_ = kLimitBroken;
  json_->values["finished"] = false;
  json_->values["end_reason"] =
      fmt::format("{}, at {:.4g} s", breaches_.front().second, breaches_.front().first);
}

bool Summary::finished() const {
  return json_->values["finished"];
}

void Summary::EndedBy(const std::string& reason, int exit_code) {
  json_->values["finished"] = false;
  json_->values["end_reason"] = reason;
  exit_code_ = exit_code;
}

namespace {

void WriteJson(const nlohmann::ordered_json& values, const fs::path& file) {
  WriteFile(file, values.dump(2) + '\n');
}

/// Nested figures by dotted names, foot_error_max_m.front_left.
std::vector<std::pair<std::string, nlohmann::ordered_json>> Flatten(const nlohmann::ordered_json& values) {
  std::vector<std::pair<std::string, nlohmann::ordered_json>> flat;
  for (const auto& [key, value] : values.items()) {
    if (!value.is_object()) {
      flat.emplace_back(key, value);
      continue;
    }
    for (auto& [name, item] : Flatten(value)) flat.emplace_back(key + "." + name, std::move(item));
  }
  return flat;
}

/// Puts the limits of a figure behind it, all with the digits that tell them apart.
void ShowLimits(double number, const Limits& limits, FigureText* figure) {
  constexpr int kDigits = 4;
  std::string low, high;
  const auto add = [&](const std::optional<double>& limit, std::string& text) {
    if (!limit) return;
    const auto [shown, beside] = Beside(number, *limit, kDigits);
    std::string& value = figure->values.front().second;
    if (shown.size() > value.size()) value = shown;
    text = beside;
  };
  add(limits.low, low);
  add(limits.high, high);
  if (limits.low && limits.high) {
    figure->limit = fmt::format("   (from {} to {})", low, high);
  } else if (limits.low) {
    figure->limit = fmt::format("   (at least {})", low);
  } else if (limits.high) {
    figure->limit = fmt::format("   (at most {})", high);
  }
}

}  // namespace

std::vector<std::pair<std::string, std::string>> Summary::Flat() const {
  std::vector<std::pair<std::string, std::string>> flat;
  for (const auto& [name, value] : Flatten(json_->values)) {
    std::string text;
    if (value.is_string()) {
      text = value.get<std::string>();
    } else if (!value.is_null()) {
      text = value.is_number_float() ? fmt::format("{}", value.get<double>()) : value.dump();
    }
    flat.emplace_back(name, std::move(text));
  }
  return flat;
}

void Summary::Write(const fs::path& file) const {
  nlohmann::ordered_json values = json_->values;
  for (const auto& [key, limit] : limits_) {
    auto& object = values[kLimits][key] = nlohmann::ordered_json::object();
    if (limit.low) object["low"] = *limit.low;
    if (limit.high) object["high"] = *limit.high;
  }
  if (!notes_.empty()) values[kNotes] = notes_;
  WriteJson(values, file);
}

void Summary::AddTo(Report& report) const {
  const auto& values = json_->values;
  const double end = values["simulated_s"];
  const std::string reason = values["end_reason"];
  report.Conclude(finished(), finished() ? fmt::format("finished after {:.4g} s", end)
                              : judged_  ? fmt::format("ran for {:.4g} s, but {}", end, reason)
                                         : fmt::format("ended at {:.4g} s: {}", end, reason));
  if (!finished() && !judged_) report.AddEvent(end, reason);
  for (const auto& [time, breach] : breaches_) report.AddEvent(time, breach);
  if (!notes_.empty()) report.AddFigure(kNotes, fmt::format("{}", fmt::join(notes_, "; ")));
  for (const auto& [name, value] : Flatten(values)) {
    if (name == "finished" || name == "fell" || name == "end_reason") continue;  // these are the verdict
    if (value.is_number() || value.is_null()) {
      const auto limits = std::ranges::find_if(limits_, [&key = name](const auto& limit) {
        return key == limit.first || key.starts_with(limit.first + ".");
      });
      report.AddFigure(name, value.is_null() ? std::nullopt : std::optional<double>(value),
                       limits == limits_.end() ? Limits{} : limits->second);
    } else {
      report.AddFigure(name, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
}

void Summary::Print() const {
  std::vector<FigureText> figures = FigureTexts(Flat());
  for (FigureText& figure : figures) {
    const auto limit = std::ranges::find(limits_, figure.key, &std::pair<std::string, Limits>::first);
    if (limit == limits_.end() || figure.values.size() != 1) continue;
    const auto value = json_->values.find(figure.key);
    if (value != json_->values.end() && value->is_number())
      ShowLimits(value->get<double>(), limit->second, &figure);
  }
  fmt::print("{}", FigureLines(figures));
  for (const std::string& note : notes_) fmt::print("{:<28} {}\n", "note", note);
}

void PrintReportPath(const fs::path& directory) {
  const fs::path report = directory / "report.html";
  std::error_code ignored;
  if (!directory.empty() && fs::exists(report, ignored))
    fmt::print("\n{:<28} {}\n", "report", report.string());
}

int PrintResult(const Summary& summary, const RunOptions& options) {
  summary.Print();
  PrintReportPath(options.out);
  return summary.exit_code();
}

void SetParameters(Context& context, const std::map<std::string, std::vector<double>>& values) {
  if (values.empty()) return;
  std::vector<std::string> paths;
  for (const internal::ParameterSource* parameter : context.diagram().parameters())
    paths.push_back(parameter->path());
  for (const auto& [path, numbers] : values) {
    const std::string key = "parameters." + path;
    try {
      if (std::ranges::count(paths, path) == 0)
        throw ParameterError(fmt::format("there is no Parameter '{}' in this diagram; did you mean '{}'?",
                                         path, internal::NearestName(path, paths)));
      context.SetDoubles(context.diagram().Find(path), numbers);
    } catch (const Error& error) {
      throw KeyError(key, error.what());
    }
  }
}

void SayNotes(const RunOptions& options, const std::vector<std::string>& notes) {
  for (const std::string& note : notes)
    Say(fmt::format("{}warning: {}\n", options.name.empty() ? "" : options.name + ": ", note));
}

std::shared_ptr<LogSink> InBackground(std::shared_ptr<LogSink> sink) {
  return std::make_shared<BackgroundLog>(std::vector{std::move(sink)});
}

int TryToWrite(const std::function<void()>& write) {
  MemoryReserve::Refill();  // a run may have ended because there was no more
  try {
    write();
    return kRan;
  } catch (const OutputError& error) {
    Say(fmt::format("{}\n", error.what()));
    return kOutputFailed;
  } catch (const std::bad_alloc&) {
    Say("out of memory while the results are written: log less often, see log_rate_hz\n");
    return kNumericalFailure;
  }
}

void WriteResults(const fs::path& directory, Summary& summary, Report& report) {
  summary.AddTo(report);
  int code = TryToWrite([&] { summary.Write(directory / "summary.json"); });
  code = std::max(code, TryToWrite([&] { report.Write(directory / "report.html"); }));
  if (code != kRan) summary.set_exit_code(code);
}

void Summary::WriteComparison(const Named& runs, const fs::path& file) {
  using Object = nlohmann::ordered_json::object_t;
  nlohmann::ordered_json all = Object();
  // As into the vector that it is: an ordered object would look through all names for each.
  Object::Container& entries = all.get_ref<Object&>();
  for (const auto& [name, summary] : runs) entries.emplace_back(name, summary.json_->values);
  WriteJson(all, file);
}

void Summary::PrintComparison(const Named& runs) {
  std::vector<std::pair<std::string, NamedTexts>> flat;
  for (const auto& [name, summary] : runs) flat.emplace_back(name, summary.Flat());
  fmt::print("{}", FigureColumns(flat));
}

}  // namespace tenon::apps
