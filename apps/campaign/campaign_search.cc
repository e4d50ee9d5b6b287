#include <tenon/apps/campaign/campaign_desk.h>
#include <tenon/systems/campaign/sampling.h>
#include <tenon/systems/report/campaign_report.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/version.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <nlopt.hpp>

#include <tuple>

namespace tenon::apps {
namespace {

namespace fs = std::filesystem;

/// The result of one evaluation: a campaign with fixed values of the keys.
struct Evaluation {
  CampaignPlan::Chosen values = {};
  std::map<std::string, double> figures = {};  ///< mean over the finished runs that have a number
  std::size_t runs = 0, finished = 0;
  double cost = 0;
  /// Sum of what the means exceed their bounds by, relative to these; infinite if no run finished.
  double violation = 0;
  std::string reason = {};  ///< why the last run failed, or which bound is exceeded

  bool good() const { return finished == runs && violation == 0; }
  /// Order of preference: the constraints first, then the cost.
  auto rank() const { return std::tuple(violation, cost); }
};

nlohmann::ordered_json JsonOf(const Evaluation& evaluation) {
  return {{"values", evaluation.values},
          {"cost", evaluation.cost},
          {"runs", evaluation.runs},
          {"finished", evaluation.finished},
          {"figures", evaluation.figures}};
}

/// Thrown when a signal stops the search.
struct Stopped : std::exception {};

class Search {
 public:
  Search(const YamlDocument& file, const ScenarioApp& app, const fs::path& directory, int jobs, bool resume)
      : file_(file),
        app_(app),
        what_(*CampaignPlan(file).file().optimise),
        directory_(directory),
        jobs_(jobs),
        resume_(resume) {}

  int Run() {
    fs::create_directories(directory_ / "evaluations");
    table_ = std::make_unique<CampaignTable>(directory_ / "search.csv", CampaignTable::Start::kNew);
    const std::vector<double> first = First();
    Evaluate(first);
    const auto dimensions = first.size();
    const auto spread = static_cast<std::size_t>(what_.evaluations / 3);
    const auto points = Sobol(spread, dimensions);
    std::vector<double> start = first;
    auto least = all_.front().rank();
    for (std::size_t k = 0; k < spread; ++k) {
      std::vector<double> shares;
      for (std::size_t i = 0; i < dimensions; ++i) shares.push_back(points[i][k]);
      if (const auto rank = Evaluate(shares).rank(); rank < least)
        std::tie(least, start) = std::tie(rank, shares);
    }
    if (all_.size() < static_cast<std::size_t>(what_.evaluations)) Optimise(start);

    const Evaluation found = best();
    nlohmann::ordered_json summary{{"tenon", Version()},
                                   {"evaluations", all_.size()},
                                   {"best", JsonOf(found)},
                                   {"first", JsonOf(all_.front())}};
    fmt::print("best: cost {:.6g} (first values: {:.6g}), {} of {} finished\n ", found.cost,
               all_.front().cost, found.finished, found.runs);
    for (const auto& [name, value] : found.values) fmt::print(" {}={:g}", name, value);
    fmt::print("\n");
    if (what_.held_back) {
      for (const auto& [name, values] :
           {std::pair("best", found.values), std::pair("first", all_.front().values)}) {
        const Evaluation held =
            RunAll(values, directory_ / fmt::format("held_back_{}.csv", name), what_.held_back);
        summary["held_back"][name] = JsonOf(held);
        fmt::print("held back, {} values: cost {:.6g}, {} of {} finished\n", name, held.cost, held.finished,
                   held.runs);
      }
    }
    WriteFile(directory_ / "summary.json",
              summary.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + '\n');
    WriteReport();
    fmt::print("{}\n", (directory_ / "report.html").string());
    return found.good() ? kRan : kLimitBroken;
  }

 private:
  /// Returns the values at a point of the unit cube, with the digits that are printed.
  CampaignPlan::Chosen At(const std::vector<double>& shares) const {
    CampaignPlan::Chosen values = {};
    std::size_t i = 0;
    for (const auto& [name, key] : what_.vary) {
      const double share = shares[i++];
      const double value = key.logarithmic ? key.from * std::pow(key.to / key.from, share)
                                           : key.from + share * (key.to - key.from);
      values[name] = std::clamp(std::stod(fmt::format("{:.6g}", value)), key.from, key.to);
    }
    return values;
  }

  std::vector<double> First() const {
    std::vector<double> shares;
    for (const auto& [name, key] : what_.vary) {
      const double middle = key.logarithmic ? std::sqrt(key.from * key.to) : (key.from + key.to) / 2;
      const double at = key.start.value_or(middle);
      shares.push_back(key.logarithmic ? std::log(at / key.from) / std::log(key.to / key.from)
                                       : (at - key.from) / (key.to - key.from));
    }
    return shares;
  }

  const Evaluation& Evaluate(const std::vector<double>& shares) {
    const CampaignPlan::Chosen values = At(shares);
    const auto known = std::ranges::find(all_, values, &Evaluation::values);
    if (known != all_.end()) return *known;  // NLopt can come back to a point
    const std::size_t index = all_.size();
    const Evaluation& made = all_.emplace_back(
        RunAll(values, directory_ / "evaluations" / fmt::format("{}.csv", index), std::nullopt));
    table_->Append(RowOf(index, made));
    std::string line = fmt::format("{:>5}", index);
    for (const auto& [name, value] : values) line += fmt::format("  {}={:g}", name, value);
    fmt::print("{}  cost {:.6g}, {} of {} finished{}{}\n", line, made.cost, made.finished, made.runs,
               made.reason.empty() ? "" : ": ", made.reason);
    std::fflush(stdout);
    return made;
  }

  /// Evaluates a point until all evaluations are used up. NLopt does not pass on other exceptions than its
  /// own.
  const Evaluation& EvaluateForNlopt(const std::vector<double>& shares) {
    try {
      if (all_.size() < static_cast<std::size_t>(what_.evaluations)) return Evaluate(shares);
    } catch (...) {
      failure_ = std::current_exception();
    }
    throw nlopt::forced_stop();
  }

  /// Makes all runs of the campaign with these values that `table` does not have.
  Evaluation RunAll(const CampaignPlan::Chosen& values, const fs::path& table,
                    std::optional<SeedRange> seeds) const {
    const CampaignPlan plan(file_, values, seeds);
    const CampaignRunner runner(plan, file_, app_);
    CampaignSchedule schedule(plan, {}, 1);
    std::size_t before = 0;
    CampaignTable rows(table, resume_ ? CampaignTable::Start::kResume : CampaignTable::Start::kNew);
    CampaignTable::Read(table, plan, [&](std::size_t run, const CampaignRow& row) {
      for (const auto& [name, value] : values)
        if (Cell(row, name) != fmt::format("{}", value))
          throw ParameterError(
              fmt::format("'{}': run {} has {} = {} instead of {}: begin the search in a new --out",
                          table.string(), run, name, Cell(row, name), value));
      schedule.Done(run, Cell(row, "finished") == "true");
      ++before;
    });
    CampaignDesk desk(schedule, rows, before);
    WorkInThreads(desk, runner, jobs_);
    desk.Close();
    if (SignalGuard::caught() != 0 || !schedule.finished()) throw Stopped();
    if (desk.lost() > 0)
      throw OutputError(
          fmt::format("{} runs could not be completed on this machine: {}; continue with --resume",
                      desk.lost(), desk.why_lost()));
    rows.Finish([](std::size_t) { return true; });

    Evaluation result{.values = values};
    std::map<std::string, std::pair<double, std::size_t>> sums;
    CampaignTable::Read(table, plan, [&](std::size_t, const CampaignRow& row) {
      ++result.runs;
      const bool finished = Cell(row, "finished") == "true";
      double cost = 0;
      for (const auto& [figure, weight] : what_.minimise)
        cost += weight * internal::NumberIn<double>(Cell(row, figure)).value_or(NAN);
      result.cost += finished && std::isfinite(cost) ? cost : what_.failed_run_cost;
      if (!finished) {
        result.reason = Cell(row, "end_reason");
        return;
      }
      ++result.finished;
      for (const auto& [name, text] : row) {
        if (name == "run" || name == "seed" || values.contains(name) || DependsOnMachine(name)) continue;
        const auto number = internal::NumberIn<double>(text);
        if (!number && text != "null") continue;
        auto& [sum, count] = sums[name];
        if (!number || !std::isfinite(*number)) continue;
        sum += *number;
        ++count;
      }
    });
    result.cost /= static_cast<double>(result.runs);
    std::vector<std::string> names;
    for (const auto& [name, sum] : sums) {
      names.push_back(name);
      result.figures[name] = sum.second > 0 ? sum.first / static_cast<double>(sum.second) : NAN;
    }
    if (result.finished == 0) {
      if (!what_.subject_to.empty()) result.violation = std::numeric_limits<double>::infinity();
      return result;
    }
    const auto demand = [&](const char* key, const std::string& figure) {
      if (!sums.contains(figure))
        throw ParameterError(fmt::format("{}: there is no figure '{}'; did you mean '{}'?",
                                         file_.PlaceOf(fmt::format("optimise.{}", key)), figure,
                                         internal::NearestName(figure, names)));
    };
    for (const auto& [figure, weight] : what_.minimise) demand("minimise", figure);
    for (const auto& [figure, bound] : what_.subject_to) {
      demand("subject_to", figure);
      const double beyond = (result.figures[figure] - bound) / (bound == 0 ? 1 : std::abs(bound));
      result.violation +=
          std::isfinite(beyond) ? std::max(beyond, 0.0) : std::numeric_limits<double>::infinity();
      if (!(beyond <= 0))
        result.reason = fmt::format("{} is {:.4g}, above {:.4g}", figure, result.figures[figure], bound);
    }
    return result;
  }

  CampaignRow RowOf(std::size_t index, const Evaluation& evaluation) const {
    CampaignRow row{{"run", fmt::format("{}", index)}};
    for (const auto& [name, value] : evaluation.values) row.emplace_back(name, fmt::format("{}", value));
    row.emplace_back("cost", fmt::format("{}", evaluation.cost));
    row.emplace_back("runs", fmt::format("{}", evaluation.runs));
    row.emplace_back("runs_finished", fmt::format("{}", evaluation.finished));
    for (const auto& [name, value] : evaluation.figures) row.emplace_back(name, fmt::format("{}", value));
    row.emplace_back("finished", evaluation.good() ? "true" : "false");
    row.emplace_back("end_reason", evaluation.reason);
    return row;
  }

  void Optimise(std::vector<double> start) {
    const bool bobyqa = what_.subject_to.empty() && start.size() > 1;  // NLopt's BOBYQA demands two variables
    nlopt::opt optimizer(bobyqa ? nlopt::LN_BOBYQA : nlopt::LN_COBYLA, static_cast<unsigned>(start.size()));
    optimizer.set_lower_bounds(0);
    optimizer.set_upper_bounds(1);
    optimizer.set_initial_step(0.15);
    optimizer.set_xtol_abs(0.003);
    static constexpr double kWorst = 1e6;  // NLopt needs finite values
    optimizer.set_min_objective(
        [](const std::vector<double>& shares, std::vector<double>&, void* search) {
          return static_cast<Search*>(search)->EvaluateForNlopt(shares).cost;
        },
        this);
    if (!what_.subject_to.empty())
      optimizer.add_inequality_constraint(
          [](const std::vector<double>& shares, std::vector<double>&, void* search) {
            return std::min(static_cast<Search*>(search)->EvaluateForNlopt(shares).violation, kWorst);
          },
          this);
    double cost = 0;
    try {
      optimizer.optimize(start, cost);
    } catch (const nlopt::roundoff_limited&) {  // converged to rounding
    } catch (const nlopt::forced_stop&) {
      if (failure_) std::rethrow_exception(failure_);
    }
  }

  const Evaluation& best() const { return *std::ranges::min_element(all_, {}, &Evaluation::rank); }
  /// The report of a campaign whose runs are the evaluations.
  void WriteReport() const {
    const CampaignFile file = CampaignPlan(file_).file();
    CampaignReport report{
        .title = file.description.empty() ? "Search for values of " + file.scenario : file.description,
        .description =
            fmt::format("{}, {}: each run is an evaluation, a campaign of {} runs with these values",
                        file.app, file.scenario, all_.front().runs)};
    for (const auto& [name, key] : what_.vary) report.drawn.push_back(name);
    report.figures = {"cost", "evaluation", "runs_finished"};
    for (const auto& [name, value] : best().figures) report.figures.push_back(name);
    for (std::size_t i = 0; i < all_.size(); ++i) {
      CampaignReport::Run run{.index = i, .survived = all_[i].good(), .reason = all_[i].reason};
      for (const auto& [name, value] : all_[i].values) run.drawn.push_back(value);
      run.figures = {all_[i].cost, static_cast<double>(i), static_cast<double>(all_[i].finished)};
      for (const auto& [name, value] : best().figures) {
        const auto found = all_[i].figures.find(name);
        run.figures.push_back(found == all_[i].figures.end() ? NAN : found->second);
      }
      report.runs.push_back(std::move(run));
    }
    const RunSetup setup = CampaignPlan(file_, best().values).Setup(0);
    std::string command = fmt::format("{} {} --seed {}", file.app, setup.scenario, setup.seed);
    for (const auto& [key, value] : setup.settings) command += " --set " + ShellQuoted(key + "=" + value);
    report.picks.push_back({.index = static_cast<std::size_t>(
                                std::ranges::find(all_, best().values, &Evaluation::values) - all_.begin()),
                            .why = "the best values; the command makes the first of their runs",
                            .command = command});
    report.Write(directory_ / "report.html");
  }

  const YamlDocument& file_;
  const ScenarioApp& app_;
  Optimisation what_;
  fs::path directory_;
  int jobs_;
  bool resume_;
  std::vector<Evaluation> all_;
  std::unique_ptr<CampaignTable> table_;
  std::exception_ptr failure_;
};

}  // namespace

int SearchCampaign(const YamlDocument& file, const ScenarioApp& app, const fs::path& directory, int jobs,
                   bool resume) {
  try {
    return Search(file, app, directory, jobs, resume).Run();
  } catch (const Stopped&) {
    return 128 + (SignalGuard::caught() != 0 ? SignalGuard::caught() : 15);
  }
}

}  // namespace tenon::apps
