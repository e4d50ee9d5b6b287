#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/summary.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/report/internal/report_json.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/version.h>

#include <fmt/format.h>

namespace tenon::apps {

namespace fs = std::filesystem;

struct Summary::Json {
  nlohmann::ordered_json values;
};

namespace {

constexpr const char *kLimits = "limits", *kNotes = "notes", *kTenon = "tenon";

/// Returns the figures to show: all except the version, which is in the files.
std::vector<std::pair<std::string, std::string>> Shown(const Summary& summary) {
  auto figures = summary.Flat();
  std::erase_if(figures, [](const auto& figure) { return figure.first == kTenon; });
  return figures;
}

std::optional<double> NumberIn(const nlohmann::ordered_json& object, const char* key) {
  if (!object.contains(key)) return std::nullopt;
  return object[key].get<double>();
}

/// Returns null without a value, and the name of a value that is no number, which JSON does not have.
nlohmann::ordered_json FigureJson(std::optional<double> value) {
  if (!value || std::isfinite(*value)) return internal::JsonOrNull(value);
  return std::isnan(*value) ? "NaN" : *value > 0 ? "Infinity" : "-Infinity";
}

void WriteJson(const nlohmann::ordered_json& values, const fs::path& file) {
  WriteFile(file, values.dump(2) + '\n');
}

/// Flattens nested figures to dotted keys: foot_error_max_m.front_left.
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

/// Adds the limits to the text of a figure, with enough digits to distinguish them from its value.
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

Summary::Summary(const std::string& case_name, std::uint64_t seed, const RunOutcome& outcome)
    : json_(std::make_unique<Json>()), ended_by_(outcome.status.monitor) {
  const bool failed = !outcome.failure.empty();
  exit_code_ = outcome.exit_code;
  auto& values = json_->values;
  values["case"] = case_name;
  values["seed"] = seed;
  values["finished"] = exit_code_ == kRan;
  values["fell"] = false;
  values["end_reason"] = failed                 ? outcome.failure
                         : outcome.status.ended ? outcome.status.reason
                                                : "end of the run";
  values["simulated_s"] = outcome.status.time;
  values["wall_s"] = outcome.wall_s;
  auto& factor = values["real_time_factor"];  // null without any time
  if (outcome.wall_s > 0) factor = outcome.status.time / outcome.wall_s;
  values[kTenon] = Version();
}

Summary::Summary(std::unique_ptr<Json> json, int exit_code) : json_(std::move(json)), exit_code_(exit_code) {}

Summary Summary::Load(const fs::path& file, int exit_code) {
  std::ifstream in = OpenInput(file);
  auto json = std::make_unique<Json>();
  json->values = nlohmann::ordered_json::parse(in, nullptr, false);
  if (!json->values.is_object() || !json->values.contains("finished") ||
      !json->values["finished"].is_boolean())
    throw RunError(fmt::format("'{}' is not a summary of a run: check whether another program overwrote it",
                               file.string()));
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
  json_->values[key] = FigureJson(value);
  if (value && std::isnan(*value) && exit_code_ == kRan)
    EndedBy(fmt::format("the figure {} is not a number", key), kNumericalFailure);
}
void Summary::Set(const std::string& key, const std::string& value) {
  json_->values[key] = value;
}
void Summary::Set(const std::string& key,
                  const std::vector<std::pair<std::string, std::optional<double>>>& values) {
  auto& object = json_->values[key] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : values) {
    object[name] = FigureJson(value);
    if (value && std::isnan(*value) && exit_code_ == kRan)
      EndedBy(fmt::format("the figure {}.{} is not a number", key, name), kNumericalFailure);
  }
}

void Summary::SetFell(const Monitor& fall) {
  json_->values["fell"] = ended_by_ != nullptr && ended_by_ == FindCurrent(fall);
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

void Summary::Require(const Condition& condition) {
  Set(condition.key, condition.met_at);
  const double end = json_->values["simulated_s"];
  if (condition.due && *condition.due <= end && !condition.met_at)
    Break(*condition.due, std::string("the point of the case did not happen: ") + condition.missed);
}

void Summary::Require(const std::string& key, const Limits& limits, double due) {
  const auto flat = Flat();
  const auto figure = std::ranges::find(flat, key, &std::pair<std::string, std::string>::first);
  if (figure == flat.end()) {
    std::vector<std::string> names;
    for (const auto& [name, value] : flat) names.push_back(name);
    throw KeyError("task.figures." + key, fmt::format("the run has no figure '{}'; did you mean '{}'?", key,
                                                      internal::NearestName(key, names)));
  }
  Limit(key, limits);
  const double end = json_->values["simulated_s"];
  if (due > end) return;
  const auto number = internal::NumberIn<double>(figure->second);
  const auto miss = [&](const std::string& what) {
    Break(end, fmt::format("the task was not done: {} {}", key, what));
  };
  const auto compare = [&](const char* word, double limit) {
    const auto [value, beside] = Beside(*number, limit, 4);
    miss(fmt::format("is {}, but must be {} {}", value, word, beside));
  };
  if (!number) {
    miss("has no value");
  } else if (limits.low && !(*number >= *limits.low)) {
    compare("at least", *limits.low);
  } else if (limits.high && !(*number <= *limits.high)) {
    compare("at most", *limits.high);
  }
}

bool Summary::finished() const {
  return json_->values["finished"];
}

void Summary::EndedBy(const std::string& reason, int exit_code) {
  json_->values["finished"] = false;
  json_->values["end_reason"] = reason;
  exit_code_ = exit_code;
}

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
    if (name == "finished" || name == "fell" || name == "end_reason") continue;  // part of the verdict
    if (name == kTenon) continue;                                                // the page names it
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
  std::vector<FigureText> figures = FigureTexts(Shown(*this));
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

void Summary::WriteComparison(const Named& runs, const fs::path& file) {
  using Object = nlohmann::ordered_json::object_t;
  nlohmann::ordered_json all = Object();
  // An ordered object searches all names at each insertion; its underlying vector does not.
  Object::Container& entries = all.get_ref<Object&>();
  for (const auto& [name, summary] : runs) entries.emplace_back(name, summary.json_->values);
  WriteJson(all, file);
}

void Summary::PrintComparison(const Named& runs) {
  std::vector<std::pair<std::string, NamedTexts>> flat;
  for (const auto& [name, summary] : runs) flat.emplace_back(name, Shown(summary));
  fmt::print("{}", FigureColumns(flat));
}

}  // namespace tenon::apps
