#include <tenon/apps/common/outputs.h>

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include <tenon/systems/framework/errors.h>

namespace tenon::apps {

namespace fs = std::filesystem;

namespace {

void WriteText(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out)
    throw ParameterError(fmt::format("cannot write '{}': choose another --out or --graph", file.string()));
}

}  // namespace

OutputDirectory::OutputDirectory(const CommonArguments& arguments, const std::string& scenario_yaml)
    : path_(arguments.out.empty() ? fs::path("out") / fs::path(arguments.scenario).stem()
                                  : fs::path(arguments.out)),
      graph_(arguments.graph) {
  std::error_code error;
  fs::create_directories(path_, error);
  if (error) {
    throw ParameterError(fmt::format("cannot make the output directory '{}' ({}): choose another --out",
                                     path_.string(), error.message()));
  }
  WriteText(path_ / "scenario.yaml", scenario_yaml);
}

void OutputDirectory::WriteGraph(const Diagram& diagram) const {
  if (graph_.empty()) return;
  if (graph_.extension() == ".dot") return WriteText(graph_, diagram.Graphviz());
  if (graph_.extension() != ".svg") {
    throw ParameterError(fmt::format("--graph {}: name a file that ends in .svg or .dot", graph_.string()));
  }
  WriteText(graph_, "");  // says so at once if the place cannot be written
  const std::string command = fmt::format("dot -Tsvg -o '{}'", graph_.string());
  std::FILE* dot = popen(command.c_str(), "w");
  const std::string text = diagram.Graphviz();
  if (dot != nullptr) std::fwrite(text.data(), 1, text.size(), dot);
  if (dot == nullptr || pclose(dot) != 0) {
    throw ParameterError(fmt::format(
        "--graph {}: Graphviz's `dot` failed; install graphviz, or write a .dot file", graph_.string()));
  }
}

struct Summary::Json {
  nlohmann::ordered_json values;
};

Summary::Summary(const std::string& case_name, std::uint64_t seed, const RunOutcome& outcome)
    : json_(std::make_unique<Json>()) {
  const bool failed = !outcome.failure.empty();
  exit_code_ = failed ? kNumericalFailure : outcome.status.ended ? kLimitBroken : kRan;
  auto& values = json_->values;
  values["case"] = case_name;
  values["seed"] = seed;
  values["finished"] = exit_code_ == kRan;
  values["fell"] = outcome.status.ended;
  values["end_reason"] = failed                 ? outcome.failure
                         : outcome.status.ended ? outcome.status.reason
                                                : "end of the run";
  values["simulated_s"] = outcome.status.time;
  values["wall_s"] = outcome.wall_s;
  values["real_time_factor"] = outcome.wall_s > 0 ? outcome.status.time / outcome.wall_s : 0;
}

Summary::Summary(Summary&&) noexcept = default;
Summary::~Summary() = default;

void Summary::Set(const std::string& key, double value) {
  json_->values[key] = value;
}
void Summary::Set(const std::string& key, const std::string& value) {
  json_->values[key] = value;
}
void Summary::Set(const std::string& key, const std::vector<std::pair<std::string, double>>& values) {
  auto& object = json_->values[key] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : values) object[name] = value;
}
void Summary::Set(const std::string& key, const std::optional<double>& value) {
  json_->values[key] = value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

namespace {

void WriteJson(const nlohmann::ordered_json& values, const fs::path& file) {
  std::ofstream out(file);
  out << values.dump(2) << '\n';
  out.close();
  if (!out) throw RunError(fmt::format("cannot write '{}'", file.string()));
}

std::string Shown(const nlohmann::ordered_json& value) {
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace

void Summary::Write(const fs::path& file) const {
  WriteJson(json_->values, file);
}

void Summary::AddTo(Report& report) const {
  const auto& values = json_->values;
  const bool finished = values["finished"];
  const double end = values["simulated_s"];
  const std::string reason = values["end_reason"];
  report.Conclude(finished, finished ? fmt::format("finished after {:.4g} s", end)
                                     : fmt::format("ended at {:.4g} s: {}", end, reason));
  if (!finished) report.AddEvent(end, reason);
  const auto flat = values.flatten();
  for (const auto& [key, value] : flat.items()) {
    std::string name = key.substr(1);  // of "/foot_error_max_m/front_left"
    std::replace(name.begin(), name.end(), '/', '.');
    if (name == "finished" || name == "fell" || name == "end_reason") continue;  // these are the verdict
    if (value.is_number() || value.is_null()) {
      report.AddFigure(name, value.is_null() ? std::nullopt : std::optional<double>(value));
    } else {
      report.AddFigure(name, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
}

void Summary::Print() const {
  for (const auto& [key, value] : json_->values.items()) fmt::print("{:<28} {}\n", key, Shown(value));
}

void Summary::WriteComparison(const Named& runs, const fs::path& file) {
  nlohmann::ordered_json all;
  for (const auto& [name, summary] : runs) all[name] = summary.json_->values;
  WriteJson(all, file);
}

void Summary::PrintComparison(const Named& runs) {
  std::vector<std::string> keys;  // of all runs, in the order of their first appearance
  for (const auto& [name, summary] : runs) {
    for (const auto& [key, value] : summary.json_->values.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  fmt::print("{:<28}", "");
  for (const auto& [name, summary] : runs) fmt::print(" {:>16}", name);
  for (const std::string& key : keys) {
    fmt::print("\n{:<28}", key);
    for (const auto& [name, summary] : runs) {
      const auto& values = summary.json_->values;
      fmt::print(" {:>16}", values.contains(key) ? Shown(values[key]) : "-");
    }
  }
  fmt::print("\n");
}

}  // namespace tenon::apps
