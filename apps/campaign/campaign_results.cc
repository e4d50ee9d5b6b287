#include <tenon/apps/campaign/campaign_desk.h>
#include <tenon/systems/report/campaign_report.h>
#include <tenon/systems/report/internal/run_log.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/version.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <cctype>
#include <set>

namespace tenon::apps {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kNull = "null";  // cell of a figure without a value

/// Numbers of runs in which a figure has no number.
struct WithoutNumber {
  std::size_t none = 0, nan = 0;  ///< null, and NaN or infinite
};

/// The numeric columns of a table: drawn values and figures.
struct Columns {
  std::vector<std::string> drawn, figures;
  std::map<std::string, WithoutNumber> without;  ///< of the columns that some runs lack
};

Columns SortColumns(const fs::path& table, const CampaignPlan& plan) {
  std::set<std::string> known{"run", "seed", "case", "finished", "fell", "end_reason"};
  for (const CampaignPlan::Axis& axis : plan.axes()) known.insert(axis.name);
  Columns columns;
  std::set<std::string> no_number;
  std::map<std::string, bool> varied;  // by name: whether the column precedes the figures
  CampaignTable::Read(table, plan, [&](std::size_t, const CampaignRow& row) {
    bool before = true;
    const bool ran = !Cell(row, "case").empty();
    for (const auto& [name, text] : row) {
      before = before && name != "case";
      if (known.contains(name) || !ran) continue;
      const auto number = internal::NumberIn<double>(text);
      if (text == kNull) {
        ++columns.without[name].none;
      } else if (!number) {
        no_number.insert(name);
      } else if (!std::isfinite(*number)) {
        ++columns.without[name].nan;
      }
      if (!varied.emplace(name, before).second) continue;
      (before ? columns.drawn : columns.figures).push_back(name);
    }
  });
  std::erase_if(columns.drawn, [&](const std::string& name) { return no_number.contains(name); });
  std::erase_if(columns.figures, [&](const std::string& name) { return no_number.contains(name); });
  return columns;
}

std::string PointName(const CampaignPlan& plan, std::size_t point) {
  std::string name;
  for (const auto& [axis, label] : plan.AtPoint(point))
    name += fmt::format("{}{}={}", name.empty() ? "" : ", ", axis, label);
  return name;
}

/// Returns the figure by which the worst runs are selected; empty if there is none.
std::string WorstBy(const CampaignPlan& plan, const std::vector<std::string>& figures) {
  const std::string& wanted = plan.file().worst_by;
  if (!wanted.empty()) {
    if (!figures.empty() && std::ranges::count(figures, wanted) == 0)
      Say(fmt::format("warning: worst_by: there is no figure '{}'; did you mean '{}'?\n",
                      internal::Excerpt(wanted), internal::NearestName(wanted, figures)));
    return wanted;
  }
  for (const char* part : {"error_max", "error"})
    for (const std::string& figure : figures)
      if (figure.find(part) != figure.npos) return figure;
  return {};
}

constexpr std::size_t kPicks = 5;  // number of listed failures and of listed worst runs

void AddPicks(CampaignReport& report, const std::string& worst_by, const std::string& command,
              const fs::path& directory) {
  const auto pick = [&](const CampaignReport::Run& run, std::string why) {
    const fs::path replay = ReplayDirectory(directory, run.index);
    report.picks.push_back({.index = run.index,
                            .why = std::move(why),
                            .command = fmt::format("{} --replay {}", command, run.index),
                            .link = fs::exists(replay / "report.html")
                                        ? fmt::format("{}/report.html", replay.filename().string())
                                        : ""});
  };
  std::size_t failed = 0;
  for (const CampaignReport::Run& run : report.runs)
    if (!run.survived && failed++ < kPicks) pick(run, run.reason);
  const auto figure = std::ranges::find(report.figures, worst_by);
  if (figure == report.figures.end()) return;
  const auto column = static_cast<std::size_t>(figure - report.figures.begin());
  std::vector<const CampaignReport::Run*> order;
  for (const CampaignReport::Run& run : report.runs)
    if (run.survived && std::isfinite(run.figures[column])) order.push_back(&run);
  std::ranges::stable_sort(order, std::greater<>(),
                           [&](const auto* run) { return std::abs(run->figures[column]); });
  for (std::size_t i = 0; i < std::min(order.size(), kPicks); ++i)
    pick(*order[i], fmt::format("{} = {:.4g}", worst_by, order[i]->figures[column]));
}

CampaignReport MakeReport(const CampaignPlan& plan, const fs::path& table, const Columns& columns) {
  const CampaignFile& file = plan.file();
  CampaignReport report{
      .title = file.description.empty() ? "Campaign of " + file.scenario : file.description,
      .description = fmt::format("{}, {}, {} points, {} seeds each from {} on", file.app, file.scenario,
                                 plan.num_points(), plan.num_seeds(), file.seeds.first),
      .drawn = columns.drawn,
      .figures = columns.figures,
      .confidence = file.confidence};
  for (const CampaignPlan::Axis& axis : plan.axes()) report.axes.push_back({axis.name, axis.labels});
  CampaignTable::Read(table, plan, [&](std::size_t run, const CampaignRow& row) {
    CampaignReport::Run item{.index = run,
                             .seed = internal::NumberIn<std::uint64_t>(Cell(row, "seed")).value_or(0),
                             .at = plan.LabelsAt(plan.PointOf(run)),
                             .survived = Cell(row, "finished") == "true",
                             .reason = std::string(Cell(row, "end_reason"))};
    const std::map<std::string_view, std::string_view> cells(row.begin(), row.end());
    const auto numbers = [&](const std::vector<std::string>& names) {
      std::vector<double> values;
      for (const std::string& name : names) {
        const auto found = cells.find(name);
        values.push_back(found == cells.end() ? NAN
                                              : internal::NumberIn<double>(found->second).value_or(NAN));
      }
      return values;
    };
    item.drawn = numbers(columns.drawn);
    item.figures = numbers(columns.figures);
    report.runs.push_back(std::move(item));
  });
  return report;
}

/// Prints in how many runs figures have no number, and adds it to the summary.
void ReportWithoutNumber(const Columns& columns, std::size_t runs, nlohmann::ordered_json* summary) {
  constexpr std::size_t kPrinted = 10;
  auto& json = (*summary)["without_number"] = nlohmann::ordered_json::object();
  for (const auto& [figure, count] : columns.without) {
    if (std::ranges::count(columns.figures, figure) == 0) continue;
    json[figure] = {{"null", count.none}, {"nan", count.nan}};
    if (json.size() <= kPrinted)
      fmt::print("{} has no number in {} of {} runs ({} null, {} NaN)\n", figure, count.none + count.nan,
                 runs, count.none, count.nan);
  }
}

struct Tally {
  std::size_t survived = 0, count = 0;
};

nlohmann::ordered_json SurvivalJson(const Tally& tally, double confidence) {
  const Interval interval = WilsonInterval(tally.survived, tally.count, confidence);
  return {{"runs", tally.count},
          {"survived", tally.survived},
          {"survival_low", interval.low},
          {"survival_high", interval.high}};
}

std::string SurvivalText(const Tally& tally, double confidence) {
  const Interval interval = WilsonInterval(tally.survived, tally.count, confidence);
  return fmt::format("{} of {} survived, {:.1f} to {:.1f} %", tally.survived, tally.count, 100 * interval.low,
                     100 * interval.high);
}

/// Value of a goal's figure in a run, with its sign changed for at_least; infinite if the run counts as
/// beyond any bound. `columns` are those of the figure.
double BeyondBy(const QuantileGoal& goal, const std::vector<std::size_t>& columns,
                const CampaignReport::Run& run) {
  constexpr double kBeyond = std::numeric_limits<double>::infinity();
  double worst = -kBeyond;
  for (const std::size_t i : columns)
    if (!std::isnan(run.figures[i])) worst = std::max(worst, goal.at_most ? run.figures[i] : -run.figures[i]);
  return run.survived && std::isfinite(worst) ? worst : kBeyond;
}

/// Prints whether the goals are met and adds them to the summary. A goal is met if the whole interval of the
/// quantile keeps the bound, missed if all of it is beyond, and open in between.
void JudgeGoals(const CampaignFile& file, const CampaignReport& report, nlohmann::ordered_json* summary) {
  for (const QuantileGoal& goal : file.goals) {
    const std::vector<std::size_t> columns = internal::FindColumns(report.figures, goal.figure);
    if (columns.empty()) {
      Say(fmt::format("warning: goals: no run has a figure '{}'; did you mean '{}'?\n",
                      internal::Excerpt(goal.figure), internal::NearestName(goal.figure, report.figures)));
      continue;
    }
    std::vector<double> values;
    for (const CampaignReport::Run& run : report.runs) values.push_back(BeyondBy(goal, columns, run));
    const double sign = goal.at_most ? 1 : -1;
    const double bound = sign * (goal.at_most ? *goal.at_most : *goal.at_least);
    const auto [value, interval] = EstimateQuantile(values, goal.quantile, file.confidence);
    const auto [low, high] = std::minmax({sign * interval.low, sign * interval.high});
    const char* verdict = interval.high <= bound ? "met" : interval.low > bound ? "missed" : "open";
    const auto json = [](double number) {
      return std::isfinite(number) ? nlohmann::ordered_json(number) : nlohmann::ordered_json();
    };
    (*summary)["goals"].push_back({{"figure", goal.figure},
                                   {"quantile", goal.quantile},
                                   {goal.at_most ? "at_most" : "at_least", sign * bound},
                                   {"value", json(sign * value)},
                                   {"low", json(low)},
                                   {"high", json(high)},
                                   {"verdict", verdict}});
    fmt::print("{} {} {:g} for {:g} % of the runs: {}, the quantile is {:.4g} ({:.4g} to {:.4g})\n",
               goal.figure, goal.at_most ? "at most" : "at least", sign * bound, 100 * goal.quantile, verdict,
               sign * value, low, high);
  }
}

}  // namespace

std::string ShellQuoted(const std::string& text) {
  const bool plain = std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) || c == '/' || c == '.' || c == '_' || c == '-' || c == '=' || c == '+';
  });
  if (plain && !text.empty()) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

fs::path ReplayDirectory(const fs::path& directory, std::size_t run) {
  return directory / fmt::format("run_{}", run);
}

void WriteResults(const CampaignPlan& plan, const CampaignSchedule& schedule, const std::string& command,
                  const fs::path& directory) {
  const CampaignFile& file = plan.file();
  const Columns columns = SortColumns(directory / "runs.csv", plan);
  CampaignReport report = MakeReport(plan, directory / "runs.csv", columns);
  report.command = command;
  AddPicks(report, WorstBy(plan, report.figures), command, directory);

  Tally all;
  std::map<std::size_t, Tally> points;
  for (const CampaignReport::Run& run : report.runs) {
    for (Tally* tally : {&all, &points[plan.PointOf(run.index)]}) {
      ++tally->count;
      tally->survived += run.survived ? 1 : 0;
    }
  }
  nlohmann::ordered_json summary{
      {"app", file.app}, {"scenario", file.scenario}, {"tenon", Version()}, {"confidence", file.confidence}};
  if (file.limit) {  // the overall survival at values of a bisection has no meaning
    summary["runs"] = all.count;
    fmt::print("{} runs\n", all.count);
  } else {
    summary.update(SurvivalJson(all, file.confidence));
    fmt::print("{}\n", SurvivalText(all, file.confidence));
  }
  summary["points"] = nlohmann::ordered_json::array();
  constexpr std::size_t kPrinted = 40;
  for (const auto& [point, tally] : points) {
    nlohmann::ordered_json entry{{"at", nlohmann::ordered_json::object()}};
    for (const auto& [axis, label] : plan.AtPoint(point)) entry["at"][axis] = label;
    if (file.limit) {
      entry["runs"] = tally.count;
      const auto [survives, fails] = schedule.LimitAt(point);
      report.limit_key = file.limit->key;
      report.limits.push_back({PointName(plan, point), survives, fails});
      entry["survives"] = survives;
      entry["fails"] = fails;
      fmt::print("  {} {}: survives {:g}, fails at {:g}\n", PointName(plan, point), file.limit->key, survives,
                 fails);
    } else {
      entry.update(SurvivalJson(tally, file.confidence));
      if (points.size() > 1 && summary["points"].size() < kPrinted)
        fmt::print("  {}: {}\n", PointName(plan, point), SurvivalText(tally, file.confidence));
    }
    summary["points"].push_back(std::move(entry));
  }
  summary["causes"] = nlohmann::ordered_json::array();
  for (const CampaignReport::Cause& cause : report.Causes()) {
    summary["causes"].push_back({{"cause", cause.text}, {"runs", cause.count}, {"first", cause.first}});
    if (summary["causes"].size() <= 10) fmt::print("{} failed: {}\n", cause.count, cause.text);
  }
  JudgeGoals(file, report, &summary);
  ReportWithoutNumber(columns, all.count, &summary);
  if (!report.picks.empty()) fmt::print("runs to inspect:\n");
  for (const CampaignReport::Pick& pick : report.picks) fmt::print("  {}    # {}\n", pick.command, pick.why);

  WriteFile(directory / "summary.json",
            summary.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n');
  report.Write(directory / "report.html");
}

}  // namespace tenon::apps
