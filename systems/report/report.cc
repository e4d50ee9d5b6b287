#include <tenon/systems/report/internal/report_json.h>
#include <tenon/systems/report/report.h>
#include <tenon/systems/simulation/background_log.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

namespace tenon {

using internal::ColumnLog;
using internal::FindColumns;
using Json = nlohmann::ordered_json;

void ReportParams::Validate() const {
  for (const Plot& plot : plots) {
    if (plot.signals.empty()) {
      throw ParameterError(fmt::format("the plot '{}' has no signals; name at least one", plot.title));
    }
    for (const auto* names : {&plot.signals, &plot.references})
      for (const std::string& name : *names)
        if (internal::IsPath(name) != internal::IsPath(plot.signals.front()))
          throw ParameterError(
              fmt::format("the plot '{}' has both paths and signals over time, '{}' and '{}': make two plots",
                          plot.title, plot.signals.front(), name));
  }
}

Report::Report(ReportParams params) : params_(std::move(params)) {
  params_.Validate();
  internal::CheckPageParts();
}
Report::~Report() = default;
Report::Report(Report&&) noexcept = default;

/// Returns the report's own run, which exists without a log if only figures or a verdict are set.
Report::Run& Report::own() {
  if (variants_.empty()) variants_.push_back({"", std::make_shared<Run>()});
  return *variants_.front().run;
}

void Report::Log(Simulator& simulator, const std::vector<const Source*>& signals,
                 const std::vector<const OutputPort<Geometry>*>& geometry) {
  Run& run = own();
  if (run.signals != nullptr)
    throw Error("this report already logs a run; make one report for each run and Add them to another");

  std::vector<std::string> names;
  bool all_known = true;  // no signal has a size known only at run time
  for (const Source* signal : signals) {
    const std::vector<Element> elements = signal->Resolve().elements();
    all_known = all_known && !elements.empty();
    for (const Element& element : elements) names.push_back(element.PathIn(signal->path()));
  }
  const auto check = [&](const std::string& place, const std::vector<std::string>& wanted) {
    for (const std::string& name : wanted) {
      const std::string logged(LoggedName(name));
      const std::size_t found = FindColumns(names, logged).size();
      if (!all_known || found > (internal::IsPath(name) ? 1U : 0U)) continue;
      if (found > 0)
        throw ParameterError(
            fmt::format("{} '{}' has one element, but a path needs two: name a vector", place, name));
      std::vector<std::string> known = names;
      for (const Source* signal : signals) known.push_back(signal->path());
      throw ParameterError(
          fmt::format("{} there is no signal '{}'; did you mean '{}'? Use the names in signals.csv", place,
                      logged, internal::NearestName(logged, known)));
    }
  };
  for (const Plot& plot : params_.plots) {
    check(fmt::format("plot '{}':", plot.title), plot.signals);
    check(fmt::format("plot '{}':", plot.title), plot.references);
  }
  check("events of the report:", params_.events);
  for (const Band& band : params_.bands) check("bands of the report:", {band.signal});
  for (const SignalLimits& limits : params_.limits) check("limits of the report:", {limits.signal});

  run.event_signals = params_.events;
  run.bands = params_.bands;
  run.limits = params_.limits;
  // The sinks hold copies, because they may outlive the report.
  run.signals = std::make_shared<ColumnLog>(ColumnLog::Thinning::kPeaks, ColumnLog::kRows, nullptr);
  using Sinks = std::vector<std::shared_ptr<LogSink>>;
  const Sinks derived{internal::WithDerived(params_.plots, run.signals)};
  simulator.AddLog(params_.signal_rate, signals, {std::make_shared<BackgroundLog>(derived)});

  // Constant properties of the shapes are not in the rows.
  run.frames = std::make_shared<ColumnLog>(ColumnLog::Thinning::kSample, ColumnLog::kFrames,
                                           [all = run.shapes, &simulator, geometry] {
                                             for (const auto* port : geometry) {
                                               const Geometry& shapes = simulator.context().Eval(*port);
                                               all->insert(all->end(), shapes.begin(), shapes.end());
                                             }
                                           });
  if (!geometry.empty()) {
    simulator.AddLog(params_.frame_rate, {geometry.begin(), geometry.end()},
                     {std::make_shared<BackgroundLog>(Sinks{run.frames})});
  }
}

void Report::AddFigure(const std::string& name, std::optional<double> value, const Limits& limits) {
  own().figures.push_back({name, internal::JsonOrNull(value), limits});
}
void Report::AddFigure(const std::string& name, const std::string& text) {
  own().figures.push_back({name, text});
}
void Report::AddEvent(double time, const std::string& label) {
  own().events.emplace_back(time, label);
}

void Report::Conclude(bool good, const std::string& verdict) {
  own().good = good;
  own().verdict = verdict;
}
void Report::Conclude(const RunStatus& status) {
  if (status.ended) AddEvent(status.time, status.reason);
  Conclude(!status.ended, status.ended ? fmt::format("ended at {:.4g} s: {}", status.time, status.reason)
                                       : fmt::format("finished after {:.4g} s", status.time));
}

void Report::Add(const std::string& variant, const Report& other) {
  if (other.variants_.size() != 1)
    throw Error(fmt::format("cannot add the variant '{}': its report must have exactly one run", variant));
  variants_.push_back({variant, other.variants_.front().run});
}

namespace {

/// Throws std::bad_alloc if that much memory is not available. Later, the destructor of a JSON value could
/// fail to allocate, which would end the process.
void DemandMemory(std::size_t bytes) {
  ::operator delete(::operator new(bytes));
}

}  // namespace

void Report::Write(const std::filesystem::path& file) const {
  if (variants_.empty()) throw RunError("the report is empty: Log a run or Add one");
  std::size_t bytes = 1 << 20;  // approximate size of the template
  for (const auto& [name, run] : variants_) bytes += run->JsonBytes();
  DemandMemory(4 * bytes);  // for the values, their text, and two copies of the page
  std::vector<Plot> plots = params_.plots;
  if (plots.empty()) {  // plots of all runs without duplicates
    for (const auto& [name, run] : variants_) {
      if (run->signals == nullptr) continue;
      for (Plot& plot : run->DefaultPlots()) {
        const auto same = [&](const Plot& other) { return other.signals == plot.signals; };
        if (std::ranges::none_of(plots, same)) plots.push_back(std::move(plot));
      }
    }
  }
  Json data{{"format", internal::kPageFormat},
            {"title", params_.title},
            {"description", params_.description},
            {"plots", internal::PlotsJson(plots)},
            {"runs", Json::array()}};
  for (const auto& [name, run] : variants_) {
    data["runs"].push_back(run->ToJson(plots, variants_.size()));
    data["runs"].back()["name"] = name;
  }
  internal::WritePage(file, params_.title, internal::Dump(data));
}

}  // namespace tenon
