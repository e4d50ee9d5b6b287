#include <tenon/apps/campaign/campaign_runner.h>

#include <fmt/core.h>

namespace tenon::apps {

CampaignRunner::CampaignRunner(const CampaignPlan& plan, const YamlDocument& file, ScenarioApp app)
    : plan_(plan), app_(std::move(app)) {
  for (const std::string& name : plan.Scenarios()) {
    try {
      scenarios_.emplace(name, LoadScenario(name, {}, app_.name));
    } catch (const ParameterError& error) {
      throw ParameterError(fmt::format("{}: {}", file.PlaceOf("scenario"), error.what()));
    }
  }
  constexpr std::size_t kMostChecks = 100;
  const std::size_t stride = (plan.num_points() + kMostChecks - 1) / kMostChecks;
  for (std::size_t point = 0; point < plan.num_points(); point += stride) {
    ++num_checked_;
    std::optional<YamlDocument> scenario;
    try {
      scenario = Prepare(plan.RunOf(point, 0, 0)).scenario;
      app_.check(*scenario);
    } catch (const OutputError&) {
      throw;  // the machine failed, not the scenario
    } catch (const Error& error) {
      if (num_refused_++ == 0) refusal_ = error.what();
      continue;
    }
    if (!plan.file().duration_s || !cut_short_.empty()) continue;
    try {
      scenario->Set("duration_s", fmt::format("{}", *plan.file().duration_s));
      app_.check(*scenario);
    } catch (const Error& error) {
      cut_short_ = error.what();
    }
  }
  if (num_refused_ < num_checked_) return;
  std::string place = file.name();
  for (const std::string part : {"set", "vary"})
    for (const std::string& key : file.Keys(part))
      if (refusal_.find("--set " + key + "=") != refusal_.npos) place = file.PlaceOf(part + "." + key);
  throw ParameterError(fmt::format("{}: no run can begin: {}", place, refusal_));
}

namespace {

CampaignRow BeginRow(std::size_t run, const RunSetup& setup) {
  CampaignRow row{{"run", fmt::format("{}", run)}, {"seed", fmt::format("{}", setup.seed)}};
  row.insert(row.end(), setup.varied.begin(), setup.varied.end());
  return row;
}

/// Returns the row of a run that could not begin.
CampaignResult Failed(CampaignRow row, const std::string& reason) {
  row.emplace_back("finished", "false");
  row.emplace_back("end_reason", reason);
  return {std::move(row), false, kBadUsage};
}

CampaignResult Judged(CampaignRow row, const Summary& summary) {
  const int code = summary.exit_code();
  const bool survived = summary.finished() && code == kRan;
  std::string reason;
  for (auto& [name, text] : summary.Flat()) {
    if (name == "end_reason") {
      reason = text;
    } else if (name == "finished") {
      row.emplace_back(name, survived ? "true" : "false");
    } else if (Cell(row, name).empty()) {  // the seed and varied keys are already in the row
      row.emplace_back(name, text.empty() ? "null" : text);
    }
  }
  if (code == kOutputFailed || reason.starts_with(kOutOfMemory))
    return {.row = {}, .exit_code = code, .machine_failure = std::move(reason)};
  row.emplace_back("end_reason", std::move(reason));
  return {std::move(row), survived, code == kRan && !survived ? kLimitBroken : code};
}

}  // namespace

CampaignRunner::Prepared CampaignRunner::Prepare(std::size_t run) const {
  const RunSetup setup = plan_.Setup(run);
  Prepared prepared{.scenario = scenarios_.at(setup.scenario), .row = BeginRow(run, setup)};
  for (const auto& [key, value] : setup.settings) prepared.scenario.Set(key, value);
  // Sorted by name, because scenarios of one campaign can have different orders of keys.
  auto drawn = DrawScenario(prepared.scenario, setup.seed);
  std::ranges::sort(drawn);
  for (const auto& [key, value] : drawn)
    if (Cell(prepared.row, key).empty()) prepared.row.emplace_back(key, fmt::format("{}", value));
  return prepared;
}

CampaignRow CampaignRunner::Begin(std::size_t run) const {
  return BeginRow(run, plan_.Setup(run));
}

std::optional<CampaignResult> CampaignRunner::Run(std::size_t run) const {
  std::optional<CampaignResult> result;
  const auto machine_failed = [&](const char* why) {
    result = CampaignResult{.row = {}, .exit_code = kOutputFailed, .machine_failure = why};
  };
  try {
    Prepared prepared = Prepare(run);
    const RunOptions options{.out = {}, .wall_limit = plan_.file().wall_limit_s};
    result = Judged(std::move(prepared.row),
                    app_.run(prepared.scenario, plan_.file().duration_s, options).summary);
  } catch (const OutputError& error) {
    machine_failed(error.what());
  } catch (const std::system_error& error) {
    machine_failed(error.what());
  } catch (const std::bad_alloc&) {
    machine_failed(kOutOfMemory);
  } catch (const std::exception& error) {
    result = Failed(Begin(run), error.what());
  }
  if (SignalGuard::caught() != 0) result.reset();
  return result;
}

CampaignResult CampaignRunner::Replay(std::size_t run, const std::filesystem::path& out) const {
  Prepared prepared = Prepare(run);
  const RunResult result = app_.run(prepared.scenario, plan_.file().duration_s,
                                    {.out = out, .wall_limit = plan_.file().wall_limit_s});
  CampaignResult judged = Judged(std::move(prepared.row), result.summary);
  if (!judged.machine_failure.empty() && SignalGuard::caught() == 0)
    throw OutputError(
        fmt::format("run {} cannot be completed on this machine: {}", run, judged.machine_failure));
  return judged;
}

std::string CampaignRunner::ScenarioTexts() const {
  std::string text;
  for (const auto& [name, document] : scenarios_)
    text += fmt::format("{}: {}\n", name, document.WithAbsolutePaths().Flow());
  return text;
}

}  // namespace tenon::apps
