// tenon-campaign: runs variations of a scenario in threads, across machines, or in parts.

#include <tenon/apps/campaign/campaign_desk.h>
#include <tenon/apps/cdpr/cdpr_app.h>
#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/guide_dog/guide_dog_app.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

namespace fs = std::filesystem;

struct CampaignArguments {
  std::string campaign;
  std::string out;
  int jobs = 0;  ///< 0: number of cores
  bool resume = false;
  bool dry_run = false;
  bool list = false;
  bool keys = false;
  std::string shard;
  std::optional<std::uint64_t> replay;
  std::vector<std::string> merge;
  std::vector<std::string> settings;
};

Shard ParseShard(const std::string& text) {
  if (text.empty()) return {};
  Shard shard;
  const std::size_t slash = text.find('/');
  const auto number = [](std::string_view part, std::size_t& value) {
    return internal::ParseNumber(part, value) == std::errc();
  };
  if (slash == text.npos || !number(std::string_view(text).substr(0, slash), shard.index) ||
      !number(std::string_view(text).substr(slash + 1), shard.count) || shard.index < 1 ||
      shard.index > shard.count)
    throw ParameterError(fmt::format("--shard {}: write i/N with i from 1 to N, as in 2/8", text));
  return shard;
}

/// Loads a campaign's file. Paths in it, also that of an app's program, are relative to the file.
YamlDocument LoadCampaign(const fs::path& path) {
  YamlDocument file = YamlDocument::Load(path.string()).WithAbsolutePaths();
  const std::string app = file.Text("app");
  if (app.find('/') != app.npos) file.Set("app", file.Path("app"));
  return file;
}

/// Returns the file as text that is valid in any directory.
std::string CampaignText(const YamlDocument& file) {
  const YamlDocument written = YamlDocument::Load(file.name());
  return written.Flow() == file.Flow() ? ReadText(file.name()) : file.Flow() + "\n";
}

ScenarioApp FindApp(const YamlDocument& file, const std::string& name) {
  if (name.find('/') != name.npos) return ProgramApp(name);
  std::string names;
  for (ScenarioApp& app :
       std::array{QuadrupedApp().AsScenarioApp(), GuideDogApp().AsScenarioApp(), CdprApp().AsScenarioApp()}) {
    if (app.name == name) return std::move(app);
    names += (names.empty() ? "" : ", ") + app.name;
  }
  throw ParameterError(fmt::format(
      "{}: there is no app '{}' for campaigns; choose one of {}, or give the path of a program, such as "
      "./{}",
      file.PlaceOf("app"), name, names, name));
}

/// Returns a hash of the data files of a directory. The source tree has code beside them.
std::string HashOf(const fs::path& directory) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(directory)) {
    const fs::path ending = entry.path().extension();
    if (entry.is_regular_file() && ending != ".h" && ending != ".cc") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  internal::Fnv1a hash;
  for (const fs::path& file : files) hash.Add(file.filename().string() + ReadText(file));
  return fmt::format("{:016x}", hash.value());
}

/// Describes the inputs of a table as text, because rows of different inputs must not be mixed.
std::string Inputs(const YamlDocument& file, const CampaignRunner& runner) {
  std::string text = fmt::format("campaign: {}\n{}", file.Flow(), runner.ScenarioTexts());
  for (const char* kind : {"robots", "hardware/legged", "hardware/cdpr", "gaits", "profiles"})
    text += fmt::format("{} that ship: {}\n", kind, HashOf(DataDirectory() / kind));
  return text;
}

void DemandSameInputs(const fs::path& directory, const std::string& inputs, const char* remedy) {
  const std::string before = ReadText(directory / "inputs.txt");
  if (before == inputs) return;
  throw ParameterError(fmt::format(
      "'{}' holds runs of {}: {}", directory.string(),
      before.empty()
          ? "no campaign"
          : "another campaign, or of scenarios, robots, hardware, gaits or profiles that have changed",
      remedy));
}

/// Removes the files of repeated runs of an earlier campaign.
void RemoveReplays(const fs::path& directory) {
  for (const auto& entry : fs::directory_iterator(directory))
    if (fs::is_directory(entry.symlink_status()) && entry.path().filename().string().starts_with("run_") &&
        fs::exists(entry.path() / "scenario.yaml"))
      OutputDirectory(entry.path());
}

int DryRun(const CampaignPlan& plan, const CampaignSchedule& schedule, const CampaignRunner& runner) {
  const auto total = schedule.total();
  fmt::print("{} points, {} seeds each, {} runs{}\n", plan.num_points(), plan.num_seeds(),
             total ? *total : plan.size(), total ? "" : " at most");
  if (plan.file().optimise)
    fmt::print("in each of at most {} evaluations\n", plan.file().optimise->evaluations);
  constexpr std::size_t kShown = 20;
  CampaignSchedule copy = schedule;
  for (std::size_t i = 0;; ++i) {
    const auto run = copy.Next();
    if (!run) return kRan;
    if (i == kShown) break;
    std::string text;
    for (const auto& [column, value] : runner.Begin(*run)) text += fmt::format("  {}={}", column, value);
    fmt::print("{}\n", text);
  }
  fmt::print("  ...\n");
  return kRan;
}

/// Returns the command line that runs the campaign again.
std::string CommandOf(const std::string& campaign, const fs::path& directory) {
  return fmt::format("tenon-campaign {} --out {}", ShellQuoted(campaign), ShellQuoted(directory.string()));
}

std::string CommandOf(const CampaignArguments& arguments, const fs::path& directory) {
  std::string command = CommandOf(arguments.campaign, directory);
  for (const std::string& setting : arguments.settings) command += " --set " + ShellQuoted(setting);
  return command;
}

int Replay(const CampaignArguments& arguments, const YamlDocument& file, const CampaignPlan& plan,
           const CampaignRunner& runner, const fs::path& directory) {
  const std::size_t run = *arguments.replay;
  if (run >= plan.size())
    throw ParameterError(fmt::format("--replay {}: the campaign has the runs 0 to {}", run, plan.size() - 1));
  const fs::path table = directory / "runs.csv";
  const bool has_table = fs::exists(table);
  if (has_table)
    DemandSameInputs(directory, Inputs(file, runner), "choose another --out to repeat only the run");
  const fs::path place = ReplayDirectory(directory, run);
  const OutputLock lock(directory);
  const CampaignResult again = runner.Replay(run, place);
  fmt::print("{}", FigureLines(FigureTexts(again.row)));
  PrintReportPath(place);
  if (!has_table || SignalGuard::caught() != 0) return again.exit_code;

  CampaignSchedule schedule(plan, {}, 1);
  CampaignTable::Read(table, plan, [&](std::size_t other, const CampaignRow& row) {
    schedule.Done(other, Cell(row, "finished") == "true");
    if (other != run) return;
    for (const auto& [column, text] : again.row)
      if (!DependsOnMachine(column) && Cell(row, column) != text)
        Say(fmt::format("warning: {} was {} in the campaign: the program or the machine has changed\n",
                        column, Cell(row, column)));
  });
  // The report links to the repeated run. An unfinished campaign has no report yet.
  if (fs::exists(directory / "report.html"))
    WriteResults(plan, schedule, CommandOf(arguments, directory), directory);
  return again.exit_code;
}

/// Returns the number of complete lines of a table of any campaign.
std::size_t RunsIn(const fs::path& table) {
  std::size_t runs = 0;
  if (fs::exists(table))
    CampaignTable::Read(table, std::numeric_limits<std::size_t>::max(),
                        [&](std::size_t, const CampaignRow&) { ++runs; });
  return runs;
}

int Merge(const CampaignArguments& arguments) {
  if (arguments.out.empty()) throw ParameterError("--merge: give the output directory by --out");
  const fs::path first = arguments.merge.front();
  const YamlDocument file = LoadCampaign(first / "campaign.yaml");
  const CampaignPlan plan(file);
  const std::string inputs = ReadText(first / "inputs.txt");
  // All parts are checked before any file is written.
  CampaignSchedule schedule(plan, {}, 1);
  std::unordered_map<std::size_t, std::uint64_t> results;
  for (const std::string& part : arguments.merge) {
    std::error_code ignored;
    if (fs::equivalent(part, arguments.out, ignored))
      throw ParameterError(fmt::format("--merge: '{}' is one of the parts: choose another --out", part));
    DemandSameInputs(part, inputs, "merge parts of one campaign");
    CampaignTable::Read(fs::path(part) / "runs.csv", plan, [&](std::size_t run, const CampaignRow& row) {
      const std::uint64_t hash = HashOfResults(row);
      if (const auto known = results.emplace(run, hash).first; known->second != hash)
        throw ParameterError(
            fmt::format("--merge: run {} has another result in '{}' than in an earlier part: run the "
                        "campaign again in one of them",
                        run, part));
      schedule.Done(run, Cell(row, "finished") == "true");
    });
  }
  const auto total = schedule.total();
  if (!total && !schedule.finished())
    throw ParameterError(
        fmt::format("--merge: the estimate of '{}' is not finished; finish it first: {} --resume",
                    first.string(), CommandOf((first / "campaign.yaml").string(), first)));
  const fs::path merged = fs::path(arguments.out) / "runs.csv";
  if (RunsIn(merged) > 0) {
    DemandSameInputs(arguments.out, inputs, "choose another --out");
    CampaignTable::Read(merged, plan, [&](std::size_t run, const CampaignRow& row) {
      if (const auto same = results.find(run); same == results.end() || same->second != HashOfResults(row))
        throw ParameterError(fmt::format(
            "--out {}: run {} in its table is in none of the parts and would be lost: choose another --out",
            arguments.out, run));
    });
  }
  const OutputDirectory out(arguments.out);
  RemoveReplays(out.path());
  WriteFile(out.path() / "campaign.yaml", ReadText(first / "campaign.yaml"));
  WriteFile(out.path() / "inputs.txt", inputs);
  CampaignTable table(out.path() / "runs.csv", CampaignTable::Start::kNew);
  std::unordered_set<std::size_t> seen;
  for (const std::string& part : arguments.merge) {
    CampaignTable::Read(fs::path(part) / "runs.csv", plan, [&](std::size_t run, const CampaignRow& row) {
      if (!seen.insert(run).second) return;  // a run of two parts has the same result in both
      table.Append(row);
    });
  }
  table.Finish([&](std::size_t run) { return total || schedule.Counts(run); });
  const std::string command = CommandOf((out.path() / "campaign.yaml").string(), out.path());
  WriteResults(plan, schedule, command, out.path());
  if (total && seen.size() < *total)
    Say(fmt::format("warning: {} of {} runs are missing: {} --resume\n", *total - seen.size(), *total,
                    command));
  return kRan;
}

/// Returns a directory beside `directory` that does not exist.
fs::path NewDirectory(const fs::path& directory) {
  fs::path beside;
  for (int i = 2; i == 2 || fs::exists(beside); ++i)
    beside = fs::path(directory / "").lexically_normal().parent_path() += fmt::format("_{}", i);
  return beside;
}

/// Runs a campaign, in all ranks of MPI if `mpi` is given.
int RunCampaign(const CampaignArguments& arguments, const YamlDocument& file, const CampaignPlan& plan,
                const CampaignRunner& runner, const Shard& shard, const fs::path& directory,
                MpiSession* mpi) {
  const std::string inputs = Inputs(file, runner);
  const fs::path table_file = directory / (plan.file().optimise ? "search.csv" : "runs.csv");
  const bool resumes = arguments.resume && fs::exists(table_file);
  if (const std::size_t done = resumes ? 0 : RunsIn(table_file); done > 0)
    throw ParameterError(
        fmt::format("'{}' holds {} runs, which are never overwritten: continue them with --resume, or choose "
                    "another --out, such as {}",
                    table_file.string(), done, ShellQuoted(NewDirectory(directory).string())));
  if (resumes) DemandSameInputs(directory, inputs, "choose another --out");
  const std::string campaign = CampaignText(file);
  std::error_code not_equivalent;
  if (fs::equivalent(directory / "campaign.yaml", file.name(), not_equivalent) &&
      campaign != ReadText(file.name()))
    throw ParameterError(
        fmt::format("--out {}: the campaign would overwrite its own file '{}': choose another --out",
                    directory.string(), file.name()));
  const OutputDirectory out(directory);
  if (!resumes) {
    std::error_code ignored;
    fs::remove(table_file, ignored);
    RemoveReplays(out.path());
    WriteFile(out.path() / "campaign.yaml", campaign);
    WriteFile(out.path() / "inputs.txt", inputs);
  }
  const int jobs = arguments.jobs > 0 ? arguments.jobs
                   : mpi != nullptr   ? 1
                                      : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  if (plan.file().optimise) {
    const int code = SearchCampaign(file, runner.app(), directory, jobs, resumes);
    if (code > 128)
      Say(fmt::format("interrupted: continue with {} --resume\n", CommandOf(arguments, directory)));
    return code;
  }
  const std::size_t workers = static_cast<std::size_t>(jobs + (mpi != nullptr ? 2 * (mpi->size() - 1) : 0));
  CampaignSchedule schedule(plan, shard, 2 * workers);
  std::size_t before = 0;
  CampaignTable table(table_file, resumes ? CampaignTable::Start::kResume : CampaignTable::Start::kNew);
  if (resumes) {
    CampaignTable::Read(table_file, plan, [&](std::size_t run, const CampaignRow& row) {
      schedule.Done(run, Cell(row, "finished") == "true");
      ++before;
    });
  }
  if (runner.num_refused() > 0)
    Say(fmt::format("warning: the scenario is invalid at {} of {} points, whose runs will fail: {}\n",
                    runner.num_refused(), runner.num_checked(), runner.refusal()));
  if (!runner.cut_short().empty())
    Say(fmt::format("warning: the scenario does not accept this duration_s: {}\n", runner.cut_short()));

  CampaignDesk desk(schedule, table, before);
  if (mpi != nullptr) {
    mpi->Lead(desk, runner, jobs);
  } else {
    WorkInThreads(desk, runner, jobs);
  }
  desk.Close();
  if (const int caught = SignalGuard::caught(); caught != 0 || !schedule.finished()) {
    Say(fmt::format("interrupted: continue with {}{} --resume\n", CommandOf(arguments, directory),
                    arguments.shard.empty() ? "" : " --shard " + arguments.shard));
    return 128 + (caught != 0 ? caught : 15);
  }
  table.Finish([&](std::size_t run) { return schedule.Counts(run); });
  const std::string command = CommandOf(arguments, directory);
  WriteResults(plan, schedule, command, out.path());
  fmt::print("{}\n", (out.path() / "report.html").string());
  if (desk.lost() == 0) return kRan;
  Say(fmt::format(
      "{} runs are missing, because the machine could not complete them: {}; run them again: {}{} "
      "--resume\n",
      desk.lost(), desk.why_lost(), command, arguments.shard.empty() ? "" : " --shard " + arguments.shard));
  return kOutputFailed;
}

void List() {
  for (const std::string& name : ListResources("campaigns"))
    fmt::print("{:<24} {}\n", name, YamlDocument::Load(FindResource("campaigns", name)).Text("description"));
}

int Run(const CampaignArguments& arguments) {
  if (arguments.list) {
    List();
    return kRan;
  }
  if (arguments.keys) {
    PrintKeys(KeysOf<CampaignFile>());
    return kRan;
  }
  if (!arguments.merge.empty()) return Merge(arguments);
  if (arguments.campaign.empty())
    throw ParameterError("no campaign given: name one (see --list), or give a YAML file");
  YamlDocument file = LoadCampaign(FindResource("campaigns", arguments.campaign));
  ApplySettings(arguments.settings, &file);
  const CampaignPlan plan(file);
  const Shard shard = ParseShard(arguments.shard);
  CampaignSchedule first(plan, shard, 1);
  if (shard.count > 1 && !first.total())
    throw ParameterError(
        "--shard: a campaign with `estimate` or `limit` selects runs by earlier results and cannot be "
        "divided; "
        "use mpirun");
  if (plan.file().optimise && (shard.count > 1 || StartedByMpi() || arguments.replay))
    throw ParameterError(fmt::format(
        "{}: a search chooses values by earlier results: run it without --shard, mpirun and --replay",
        file.PlaceOf("optimise")));
  const CampaignRunner runner(plan, file, FindApp(file, plan.file().app));
  if (arguments.dry_run) return DryRun(plan, first, runner);
  const fs::path directory =
      arguments.out.empty() ? fs::path("out") / fs::path(arguments.campaign).stem() : fs::path(arguments.out);
  const SignalGuard guard;
  if (arguments.replay) return Replay(arguments, file, plan, runner, directory);
  if (!StartedByMpi()) return RunCampaign(arguments, file, plan, runner, shard, directory, nullptr);

  MpiSession mpi;
  try {  // an error of one rank ends all ranks; otherwise they would wait
    if (mpi.rank() > 0) {
      mpi.Follow(runner);
      return kRan;
    }
    return RunCampaign(arguments, file, plan, runner, shard, directory, &mpi);
  } catch (const std::exception& error) {
    Say(fmt::format("tenon-campaign: {}\n", error.what()));
    mpi.Abort(dynamic_cast<const OutputError*>(&error) != nullptr ? kOutputFailed : kBadUsage);
  }
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  tenon::apps::CommandLine line(
      "Runs variations of a scenario and evaluates how often they survive and which parameters matter.",
      "tenon-campaign");
  tenon::apps::CampaignArguments arguments;
  line.Add("CAMPAIGN", &arguments.campaign, "name of a shipped campaign (see --list), or a YAML file");
  line.Add("--out", &arguments.out, "directory for all output (default: out/CAMPAIGN)");
  line.Add("--set", &arguments.settings, "override a value of the campaign: --set seeds.count=5",
           {.type = "KEY=VALUE", .one_value_each = true});
  line.Add("--jobs", &arguments.jobs,
           "number of parallel runs (default: one for each core; with mpirun one for each rank)",
           {.range = tenon::apps::OptionRange::kPositiveInteger});
  line.Add("--resume", &arguments.resume, "keep the runs in --out and execute missing ones");
  line.Add("--shard", &arguments.shard, "execute only part i of N, counted from 1, in an array job",
           {.type = "i/N"});
  line.Add("--dry-run", &arguments.dry_run, "check the campaign, show its first runs and stop");
  line.Add("--replay", &arguments.replay, "repeat this run with all logs and a report in --out/run_RUN",
           {.type = "RUN"});
  line.Add("--merge", &arguments.merge, "merge the parts of a campaign into --out", {.type = "DIR..."});
  line.Add("--list", &arguments.list, "list the shipped campaigns and stop");
  line.Add("--keys", &arguments.keys, "list all keys of a campaign's file and stop");
  line.SetFooter(
      "Writes runs.csv, a line for each run as it ends, then report.html and summary.json.\n"
      "Across machines: mpirun -n 64 tenon-campaign CAMPAIGN --out DIR\n"
      "As an array job: tenon-campaign CAMPAIGN --shard $SLURM_ARRAY_TASK_ID/100 --out "
      "DIR/$SLURM_ARRAY_TASK_ID,\n"
      "                 then tenon-campaign --merge DIR/* --out WHOLE\n"
      "Ctrl-C ends it after writing complete files; --resume continues it, also after a kill. A table with "
      "runs is\n"
      "never overwritten: without --resume, --out must be new.\n"
      "Exit codes: 0 all runs are done, whether they survived or not; 2 invalid usage or campaign; 3 a "
      "replayed "
      "run did not survive; 5 a file could not be written or the machine could not complete all runs; "
      "129, 130, 143 stopped by SIGHUP, Ctrl-C, SIGTERM.");
  return tenon::apps::RunMain(line, argc, argv, [&] { return tenon::apps::Run(arguments); });
}
