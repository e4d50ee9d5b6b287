#include <tenon/systems/campaign/statistics.h>
#include <tenon/systems/report/campaign_report.h>
#include <tenon/systems/report/internal/report_json.h>
#include <tenon/systems/text/text.h>

#include <cctype>
#include <iterator>
#include <random>

namespace tenon {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLines =
    1500;                          // number of lines of the parallel coordinates; more are indistinguishable
constexpr std::size_t kBins = 30;  // number of bins of a histogram
constexpr std::size_t kMedians = 4000;  // maximal number of points with medians of figures

Json SurvivalJson(std::size_t survived, std::size_t count, double confidence) {
  const Interval interval = WilsonInterval(survived, count, confidence);
  return {{"survived", survived}, {"count", count}, {"low", interval.low}, {"high", interval.high}};
}

double Median(std::vector<double>& values) {
  if (values.empty()) return NAN;
  const std::size_t half = values.size() / 2;
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(half));
  const double upper = values[half];
  if (values.size() % 2 == 1) return upper;
  return 0.5 *
         (upper + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half)));
}

/// Throws ParameterError at the first run whose values do not match the names of the report.
void CheckRuns(const CampaignReport& report) {
  for (const CampaignReport::Run& run : report.runs) {
    const auto demand = [&run](const char* values, std::size_t count, std::size_t names) {
      Demand(count == names, "CampaignReport: run " + std::to_string(run.index) + " has " +
                                 std::to_string(count) + " " + values + ", but the report names " +
                                 std::to_string(names) + ": give one for each name");
    };
    demand("labels in `at`", run.at.size(), report.axes.size());
    demand("drawn values", run.drawn.size(), report.drawn.size());
    demand("figures", run.figures.size(), report.figures.size());
    for (std::size_t i = 0; i < run.at.size(); ++i) {
      Demand(run.at[i] < report.axes[i].labels.size(),
             "CampaignReport: run " + std::to_string(run.index) + " has label " + std::to_string(run.at[i]) +
                 " of axis '" + report.axes[i].name + "', which has " +
                 std::to_string(report.axes[i].labels.size()) + " labels: count from 0");
    }
  }
}

/// Returns survival and the median of each figure at each point.
Json PointsJson(const CampaignReport& report) {
  std::map<std::vector<std::size_t>, std::vector<const CampaignReport::Run*>> points;
  for (const CampaignReport::Run& run : report.runs) points[run.at].push_back(&run);
  Json json = Json::array();
  for (const auto& [at, runs] : points) {
    const auto survived = std::ranges::count_if(runs, [](const auto* run) { return run->survived; });
    Json point = SurvivalJson(static_cast<std::size_t>(survived), runs.size(), report.confidence);
    point["at"] = at;
    point["medians"] = Json::array();
    point["missing"] = Json::array();  // number of runs without a number
    for (std::size_t i = 0; i < report.figures.size() && points.size() <= kMedians; ++i) {
      std::vector<double> values;
      for (const auto* run : runs)
        if (std::isfinite(run->figures[i])) values.push_back(run->figures[i]);
      point["medians"].push_back(Median(values));
      point["missing"].push_back(runs.size() - values.size());
    }
    json.push_back(std::move(point));
  }
  return json;
}

/// Returns histograms of a figure for runs that survived and for runs that failed.
Json HistogramJson(const CampaignReport& report, std::size_t figure) {
  std::vector<double> all;
  for (const auto& run : report.runs)
    if (std::isfinite(run.figures[figure])) all.push_back(run.figures[figure]);
  if (all.empty()) return nullptr;
  const auto [low, high] = std::ranges::minmax(all);
  std::vector<std::size_t> survived(kBins), failed(kBins);
  for (const auto& run : report.runs) {
    const double value = run.figures[figure];
    if (!std::isfinite(value)) continue;
    const double share = high > low ? (value - low) / (high - low) : 0;
    const auto bin = std::min(static_cast<std::size_t>(share * kBins), kBins - 1);
    ++(run.survived ? survived : failed)[bin];
  }
  return {{"low", low},           {"high", high},     {"median", Median(all)},
          {"survived", survived}, {"failed", failed}, {"missing", report.runs.size() - all.size()}};
}

/// Returns Spearman's rank correlation of each varied key with each figure and, last, with survival.
Json CorrelationsJson(const CampaignReport& report) {
  const auto correlate = [&](const auto& key, const auto& figure) -> Json {
    std::vector<double> x, y;
    for (const auto& run : report.runs) {
      if (!std::isfinite(figure(run)) || !std::isfinite(key(run))) continue;
      x.push_back(key(run));
      y.push_back(figure(run));
    }
    return internal::JsonOrNull(RankCorrelation(x, y));
  };
  Json rows = Json::array();
  const auto add = [&](const std::string& name, const auto& key) {
    Json row = Json::array();
    for (std::size_t i = 0; i < report.figures.size(); ++i)
      row.push_back(correlate(key, [i](const auto& run) { return run.figures[i]; }));
    row.push_back(correlate(key, [](const auto& run) { return run.survived ? 1.0 : 0.0; }));
    rows.push_back({{"name", name}, {"values", std::move(row)}});
  };
  for (std::size_t i = 0; i < report.axes.size(); ++i) {
    std::vector<double> values;  // numbers of the labels
    for (const std::string& label : report.axes[i].labels)
      values.push_back(internal::NumberIn<double>(internal::WithoutPlus(label)).value_or(NAN));
    const auto finite = [](double value) { return std::isfinite(value); };
    if (std::ranges::all_of(values, finite) && values.size() > 1)
      add(report.axes[i].name, [&, i](const auto& run) { return values[run.at[i]]; });
  }
  for (std::size_t i = 0; i < report.drawn.size(); ++i)
    add(report.drawn[i], [i](const auto& run) { return run.drawn[i]; });
  return rows;
}

Json LinesJson(const CampaignReport& report) {
  Json lines = Json::array();
  // A random sample with a fixed seed, because every n-th run may have the same seed.
  std::vector<CampaignReport::Run> shown;
  std::ranges::sample(report.runs, std::back_inserter(shown), kLines, std::mt19937(1));
  for (const CampaignReport::Run& run : shown) {
    Json line{{"run", run.index}, {"seed", run.seed}, {"survived", run.survived}, {"at", run.at}};
    line["drawn"] = run.drawn;  // numbers that are not finite become null in the text
    line["figures"] = run.figures;
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string WithoutNumbers(const std::string& reason) {
  std::string cause;
  for (std::size_t i = 0; i < reason.size(); ++i) {
    const bool digit = std::isdigit(static_cast<unsigned char>(reason[i])) != 0;
    const bool in_word =
        i > 0 && (std::isalpha(static_cast<unsigned char>(reason[i - 1])) || reason[i - 1] == '_');
    if (!digit || in_word) {
      cause += reason[i];
      continue;
    }
    while (i + 1 < reason.size() && (std::isdigit(static_cast<unsigned char>(reason[i + 1])) ||
                                     reason[i + 1] == '.' || reason[i + 1] == 'e'))
      ++i;
    cause += "…";
  }
  return cause;
}

}  // namespace

std::vector<CampaignReport::Cause> CampaignReport::Causes() const {
  std::map<std::string, Cause> groups;
  for (const Run& run : runs) {
    if (run.survived) continue;
    const std::string text = WithoutNumbers(run.reason);
    Cause& group = groups[text];
    if (group.count++ == 0) group.text = run.reason;
    if (group.text != run.reason) group.text = text;
    if (group.first.size() < 5) group.first.push_back(run.index);
  }
  std::vector<Cause> sorted;
  for (auto& [text, group] : groups) sorted.push_back(std::move(group));
  std::ranges::stable_sort(sorted, std::greater<>(), &Cause::count);
  return sorted;
}

void CampaignReport::Write(const std::filesystem::path& file) const {
  CheckRuns(*this);
  const auto survived = static_cast<std::size_t>(std::ranges::count_if(runs, &Run::survived));
  Json data{{"title", title},
            {"description", description},
            {"command", command},
            {"confidence", confidence},
            {"survival", SurvivalJson(survived, runs.size(), confidence)},
            {"drawn", drawn},
            {"figures", figures},
            {"points", PointsJson(*this)},
            {"correlations", CorrelationsJson(*this)},
            {"lines", LinesJson(*this)},
            {"limitKey", limit_key}};
  data["causes"] = Json::array();
  for (const Cause& cause : Causes())
    data["causes"].push_back({{"cause", cause.text}, {"count", cause.count}, {"first", cause.first}});
  data["axes"] = Json::array();
  for (const Axis& axis : axes) data["axes"].push_back({{"name", axis.name}, {"labels", axis.labels}});
  data["histograms"] = Json::array();
  for (std::size_t i = 0; i < figures.size(); ++i) data["histograms"].push_back(HistogramJson(*this, i));
  data["limits"] = Json::array();
  for (const Limit& limit : limits)
    data["limits"].push_back({{"point", limit.point}, {"survives", limit.survives}, {"fails", limit.fails}});
  data["picks"] = Json::array();
  for (const Pick& pick : picks)
    data["picks"].push_back(
        {{"run", pick.index}, {"why", pick.why}, {"command", pick.command}, {"link", pick.link}});
  internal::WritePage(file, title, internal::Dump(data), internal::PageKind::kCampaign);
}

}  // namespace tenon
