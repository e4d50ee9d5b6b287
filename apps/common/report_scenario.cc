#include <tenon/apps/common/report_scenario.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

#include <set>

namespace tenon::apps {

static void CheckCount(std::size_t count, const std::string& what) {
  static constexpr std::size_t kMost = 1000;  // larger pages are unreadable and too slow
  Demand(count <= kMost,
         fmt::format("{} has {} entries, but at most {} are allowed: remove some", what, count, kMost));
}

void ReportScenario::Validate() const {
  CheckCount(plots.size(), "plots");
  CheckCount(events.size(), "events");
  CheckCount(bands.size(), "bands");
  for (std::size_t i = 0; i < plots.size(); ++i) {
    CheckCount(plots[i].signals.size(), fmt::format("plots.{}.signals", i));
    CheckCount(plots[i].references.size(), fmt::format("plots.{}.references", i));
  }
}

std::vector<Plot> PlotsOf(const ReportScenario& scenario, const std::vector<Plot>& others) {
  std::vector<Plot> plots = scenario.plots;
  plots.insert(plots.end(), others.begin(), others.end());
  return plots;
}

FieldList CommonScenario::With(const FieldList& own) {
  FieldList fields{
      Required("app", &CommonScenario::app),        {"description", &CommonScenario::description},
      Required("case", &CommonScenario::case_name), {"seed", &CommonScenario::seed},
      {"report", &CommonScenario::report},          {"log", &CommonScenario::log},
      {"parameters", &CommonScenario::parameters}};
  fields.insert(fields.begin() + 3, own.begin(), own.end());  // behind the keys that name the scenario
  return fields;
}

void LogScenario::Validate() const {
  CheckCount(signals.size(), "signals");
}

namespace {

/// A name in a scenario and its key.
struct Request {
  std::string key, name;
};

std::vector<Request> RequestsOf(const CommonScenario& scenario) {
  const ReportScenario& report = scenario.report;
  std::vector<Request> requests;
  const auto add = [&](const std::string& key, const std::vector<std::string>& names) {
    for (std::size_t i = 0; i < names.size(); ++i)
      requests.push_back({fmt::format("{}.{}", key, i), std::string(LoggedName(names[i]))});
  };
  add("log.signals", scenario.log.signals);
  for (std::size_t i = 0; i < report.plots.size(); ++i) {
    add(fmt::format("report.plots.{}.signals", i), report.plots[i].signals);
    add(fmt::format("report.plots.{}.references", i), report.plots[i].references);
  }
  add("report.events", report.events);
  for (std::size_t i = 0; i < report.bands.size(); ++i)
    requests.push_back({fmt::format("report.bands.{}.signal", i), report.bands[i].signal});
  return requests;
}

/// Whether `path` is the whole or a leading part of a name with dots.
bool Begins(std::string_view path, std::string_view name) {
  return name.starts_with(path) && (name.size() == path.size() || name[path.size()] == '.');
}

/// The names of a port's columns; empty if a size is known only at run time.
std::vector<std::string> ColumnsOf(const Source& port) {
  std::vector<std::string> columns;
  for (const Element& element : port.Resolve().elements()) columns.push_back(element.PathIn(port.path()));
  return columns;
}

bool IsPort(const Source& source) {
  using enum SourceKind;
  const SourceKind kind = source.kind();
  return kind == kInput || kind == kOutput || kind == kContinuous || kind == kDiscrete || kind == kParameter;
}

bool HoldsNumbers(const Source& source) {
  using enum internal::TypeInfo::Kind;
  const auto kind = source.type().kind;
  return kind != kText && kind != kOpaque && kind != kMap;
}

void AddPorts(const std::vector<std::unique_ptr<System>>& blocks, std::vector<const Source*>& ports) {
  for (const auto& block : blocks) {
    for (const Source* source : block->sources())
      if (IsPort(*source)) ports.push_back(source);
    if (const auto* nested = dynamic_cast<const Subdiagram*>(block.get())) AddPorts(nested->blocks(), ports);
  }
}

/// Finds the port whose value, or a part of it, has this name; null if there is none. The longest path
/// counts. A state and the output that shows it may have the same path: the output is preferred.
const Source* PortOf(std::string_view name, const std::vector<const Source*>& ports) {
  const Source* found = nullptr;
  std::size_t longest = 0;
  for (const Source* port : ports) {
    const std::string path = port->path();
    if (!Begins(path, name) || path.size() < longest) continue;
    if (path.size() == longest && port->kind() != SourceKind::kOutput) continue;
    found = port;
    longest = path.size();
  }
  return found;
}

/// The names that a request may have: of ports and of parts of their values.
std::vector<std::string> NamesOf(const std::vector<const Source*>& ports) {
  std::set<std::string> names;
  for (const Source* port : ports) {
    if (!HoldsNumbers(*port)) continue;
    const std::size_t length = port->path().size();
    names.insert(port->path());
    for (const std::string& column : ColumnsOf(*port))
      for (std::size_t end = column.size(); end != column.npos && end > length;
           end = column.rfind('.', end - 1))
        names.insert(column.substr(0, end));
  }
  return {names.begin(), names.end()};
}

[[noreturn]] void Refuse(const Request& request, std::vector<std::string> names) {
  static constexpr int kShown = 3;
  std::vector<std::string> nearest;
  for (int i = 0; i < kShown && !names.empty(); ++i) {
    nearest.push_back(internal::NearestName(request.name, names));
    std::erase(names, nearest.back());
  }
  throw KeyError(request.key, fmt::format("the diagram has no port '{}'; did you mean '{}'?", request.name,
                                          fmt::join(nearest, "', '")));
}

}  // namespace

void AddRequested(const Diagram& diagram, const CommonScenario& scenario,
                  std::vector<const Source*>& signals) {
  std::vector<const Source*> ports;
  for (const Request& request : RequestsOf(scenario)) {
    const Source* port = PortOf(request.name, signals);
    const bool logged = port != nullptr;
    if (!logged) {
      if (ports.empty()) AddPorts(diagram.blocks(), ports);
      port = PortOf(request.name, ports);
    }
    if (port == nullptr) Refuse(request, NamesOf(ports));
    if (!HoldsNumbers(*port))
      throw KeyError(request.key,
                     fmt::format("'{}' is of type {}, which holds no numbers for a log: name another port",
                                 port->path(), port->type_name()));
    const std::vector<std::string> columns = ColumnsOf(*port);
    const bool has_part = columns.empty() || std::ranges::any_of(columns, [&](const std::string& column) {
                            return Begins(request.name, column);
                          });
    if (!has_part) Refuse(request, NamesOf({port}));
    if (!logged) signals.push_back(port);
  }
}

}  // namespace tenon::apps
