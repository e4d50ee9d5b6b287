#include <tenon/apps/common/command_line.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/version.h>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <iostream>
#include <sstream>

namespace tenon::apps {

namespace {

/// Refuses texts for which `fits` is false, with a message that describes the range in words.
CLI::Validator Validator(const char* name, const char* range, bool (*fits)(const std::string& text)) {
  return {[range, fits](std::string& text) {
            return fits(text) ? "" : fmt::format("{} must be {}", internal::Excerpt(text), range);
          },
          name};
}

CLI::Validator Validator(OptionRange range) {
  switch (range) {
    case OptionRange::kPositive:
      return Validator("> 0", "a positive number", [](const std::string& text) {
        const auto number = internal::NumberIn<double>(text);
        return number && std::isfinite(*number) && *number > 0;
      });
    case OptionRange::kNotNegative:
      return CLI::NonNegativeNumber;
    case OptionRange::kPositiveInteger:
      return Validator("> 0", "an integer from 1 to 2147483647", [](const std::string& text) {
        const auto number = internal::NumberIn<std::int32_t>(text);
        return number && *number > 0;
      });
    case OptionRange::kSeed:
      return Validator(">= 0", "an integer from 0 to 18446744073709551615", [](const std::string& text) {
        return internal::NumberIn<std::uint64_t>(text).has_value();
      });
    default:
      return Validator("PORT", "a port from 1 to 65535", [](const std::string& text) {
        const auto number = internal::NumberIn<int>(text);
        return number && *number > 0 && *number < 65536;
      });
  }
}

/// Opens the standard descriptors that are closed on /dev/null. Otherwise a file of the run would get such a
/// descriptor, and messages would be written into it.
void OpenStandardDescriptors() {
  int opened = 0;
  while (opened >= 0 && opened <= STDERR_FILENO) opened = ::open("/dev/null", O_RDWR);
  if (opened >= 0) ::close(opened);
}

}  // namespace

CommandLine::CommandLine(const std::string& description, const std::string& name)
    : app_(std::make_unique<CLI::App>(description, name)) {}

CommandLine::~CommandLine() = default;

void CommandLine::Add(const std::string& name, Variable variable, const std::string& help,
                      const OptionTraits& traits) {
  CLI::Option& option = *std::visit(
      [&](auto* value) {
        using T = std::remove_pointer_t<decltype(value)>;
        if constexpr (std::is_same_v<T, std::string>)
          if (name.ends_with('}')) return app_->add_flag(name, *value, help);
        if constexpr (std::is_same_v<T, bool>) {
          return app_->add_flag(name, *value, help);
        } else {
          return app_->add_option(name, *value, help);
        }
      },
      variable);
  if (traits.range != OptionRange::kAny) option.check(Validator(traits.range));
  if (traits.type != nullptr) option.type_name(traits.type);
  if (traits.count > 0) option.expected(traits.count);
  if (traits.required) option.required();
  if (traits.one_value_each) option.allow_extra_args(false);
  if (traits.shows_default) option.capture_default_str();
  if (traits.needs != nullptr) option.needs(app_->get_option(traits.needs));
  if (traits.excludes != nullptr) option.excludes(app_->get_option(traits.excludes));
}

void CommandLine::SetFooter(const std::string& text) {
  app_->footer(text);
}

bool CommandLine::Has(const std::string& name) const {
  return app_->count(name) > 0;
}

void AddScenarioArguments(CommandLine& line, CommonArguments& arguments) {
  line.Add("SCENARIO", &arguments.scenario, "name of a shipped scenario (see --list), or a YAML file");
  line.Add("--seed", &arguments.seed, "seed of all random streams", {.range = OptionRange::kSeed});
  line.Add("--set", &arguments.settings, "override a value of the scenario: --set duration_s=5",
           {.type = "KEY=VALUE", .one_value_each = true});
  line.Add("--list", &arguments.list, "list the shipped scenarios and stop");
  line.Add("--keys", &arguments.keys,
           "list all keys of scenarios with their defaults and stop; checks SCENARIO first, if given");
}

void AddAppArguments(CommandLine& line, const ScenarioApp& app, CommonArguments& arguments) {
  AddScenarioArguments(line, arguments);
  line.Add("--duration", &arguments.duration, "simulated time [s] (default: the scenario's)",
           {.range = OptionRange::kPositive});
  line.Add("--out", &arguments.out, "directory for all output (default: out/SCENARIO)");
  line.Add("--graph", &arguments.graph, "write the diagram to this file, .svg or .dot, and run");
  line.SetFooter(
      "Writes report.html, summary.json, signals.csv and scenario.yaml (every default filled in) to the "
      "output directory.\n"
      "Ctrl-C ends a run after writing complete files; a second Ctrl-C ends it at once.\n"
      "Exit codes: 0 finished; 2 invalid usage or scenario; 3 fell, broke a forbidden limit, or exceeded "
      "what drives, ground, cables or bodies can do; 4 numerical failure; 5 a file could not be written; "
      "130, 143 stopped by Ctrl-C, SIGTERM.");
  line.Add("--live{8080}", &arguments.live,
           "show and steer the run in a browser; --live PORT, default 8080 or the next free port",
           {.range = OptionRange::kPort});
  line.Add(
      "--live-address", &arguments.live_address,
      "address at which the server listens, for browsers on other machines, which need the printed token",
      {.needs = "--live"});
  line.Add("--replay", &arguments.replay,
           "repeat a live run from its live.jsonl, without a browser; tenon-quadruped: or any run from its "
           "directory",
           {.excludes = "--live"});
  line.Add("--ros2{any}", &arguments.ros2,
           "publish the robot in ROS 2, and take /cmd_vel and /joy, in real time; --ros2=INTERFACE[,DOMAIN], "
           "default as ROS 2 chooses");
  line.Add("--mcap", &arguments.mcap, "record the messages of ROS 2 in run.mcap in the output directory");
  if (app.figures.empty()) return;
  line.Add(
      fmt::format("--figure{{{}}}", kListFigures), &arguments.figure,
      "run the case of a figure of the thesis and save the figure, such as --figure 2.5; without a number, "
      "list the figures and stop",
      {.excludes = "SCENARIO"});
}

RunOptions OptionsOf(const CommonArguments& arguments) {
  const auto standard = std::filesystem::path("out") / std::filesystem::path(arguments.scenario).stem();
  return {.out = arguments.out.empty() ? standard : std::filesystem::path(arguments.out),
          .graph = arguments.graph,
          .ros2 = arguments.ros2.empty() ? std::nullopt : std::optional(arguments.ros2),
          .mcap = arguments.mcap};
}

static constexpr const char* kNoMemory =
    "out of memory before the run began: reduce large robots, lists or horizons in the scenario";

int RunMain(CommandLine& line, int argc, char** argv, const std::function<int()>& body) {
  CLI::App& app = *line.app_;
  OpenStandardDescriptors();
  std::signal(SIGXFSZ, SIG_IGN);  // at a limit of the file size, writing then fails with an error
  app.set_version_flag("--version", app.get_name() + " " + Version(), "print the version and stop");
  // `--live 8081` means `--live=8081`; any other word after --live is the scenario. So for `--figure 2.5`.
  std::vector<std::string> words;
  for (int i = argc - 1; i > 0; --i) words.emplace_back(argv[i]);  // CLI11 expects them in reverse order
  for (std::size_t i = words.size(); i-- > 1;) {
    const bool live = words[i] == "--live" && internal::NumberIn<int>(words[i - 1]);
    const bool figure = words[i] == "--figure" && !words[i - 1].starts_with('-');
    if (!live && !figure) continue;
    words[i] += "=" + words[i - 1];
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(i) - 1);
    break;
  }
  // `--set A=1 B=2` means `--set A=1 --set B=2`, unless B=2 is a file.
  for (std::size_t i = words.size(); i-- > 2;) {
    const std::string option = words[i], next = words[i - 2];
    std::error_code ignored;
    if ((option == "--set" || option == "--lock") && !next.starts_with('-') && next.find('=') != next.npos &&
        !std::filesystem::exists(next, ignored))
      words.insert(words.begin() + static_cast<std::ptrdiff_t>(i) - 1, option);
  }
  try {
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    std::ostringstream refusal;
    const int code = app.exit(error, std::cout, refusal);
    Say(refusal.str());
    if (code != 0) return kBadUsage;
    if (std::cout.flush()) return kRan;
    Say(app.get_name() + ": cannot print to stdout: check whether the disk is full\n");
    return kOutputFailed;
  }
  const auto fail = [&](const char* what, ExitCode code) {
    Say(fmt::format("{}: {}\n", app.get_name(), what));
    return code;
  };
  try {
    const std::string here = std::filesystem::current_path().string();
    CheckUtf8(here, fmt::format("the working directory '{}'", internal::Excerpt(here)));
    for (int i = 1; i < argc; ++i) CheckUtf8(argv[i], fmt::format("argument {} of the command line", i));
    const int code = body();
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      return fail("cannot print the figures to stdout: check whether the disk is full", kOutputFailed);
    return code;
  } catch (const OutputError& error) {
    return fail(error.what(), kOutputFailed);
  } catch (const RunError& error) {
    return fail(error.what(), kNumericalFailure);
  } catch (const std::bad_alloc&) {
    return fail(kNoMemory, kNumericalFailure);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::not_enough_memory) return fail(kNoMemory, kNumericalFailure);
    return fail(error.what(), kOutputFailed);
  } catch (const std::exception& error) {
    return fail(error.what(), kBadUsage);
  }
}

std::string ProgramName(char** argv) {
  return std::filesystem::path(argv[0] == nullptr ? "" : argv[0]).filename().string();
}

/// Refuses an output directory whose files of a run are those that the scenario was read from.
static void DemandOtherFiles(const std::vector<std::string>& scenario, const std::filesystem::path& out) {
  std::error_code no_such_file;
  for (const std::string& file : scenario)
    for (const char* name : {"scenario.yaml", "signals.csv", "summary.json", "report.html"})
      if (std::filesystem::equivalent(out / name, file, no_such_file))
        throw ParameterError(
            fmt::format("--out {}: the run would overwrite its own scenario '{}': choose another --out",
                        out.string(), file));
}

YamlDocument LoadScenario(const CommonArguments& arguments, const std::string& app) {
  if (arguments.scenario.empty()) {
    throw ParameterError("no scenario given: name one (see --list), or give a YAML file");
  }
  std::vector<std::string> files;
  YamlDocument document = LoadScenario(arguments.scenario, arguments.settings, app, &files);
  DemandOtherFiles(files, OptionsOf(arguments).out);
  DrawScenario(document, arguments.seed);
  return document;
}

int RunLive(CommonArguments arguments,
            const std::function<int(const CommonArguments& arguments, const RunOptions& options)>& run) {
  RunOptions options = OptionsOf(arguments);
  if (arguments.live.empty() && arguments.replay.empty()) return run(arguments, options);
  LiveSessionOptions session{.duration = arguments.duration};
  if (!arguments.live.empty()) session.port = std::stoi(arguments.live);
  if (!arguments.live_address.empty()) session.address = arguments.live_address;
  if (!arguments.replay.empty()) session.replay = arguments.replay;
  options.live = std::make_shared<LiveSession>(session);
  if (const auto seed = options.live->replay_seed()) {
    if (arguments.seed && arguments.seed != seed)
      throw ParameterError(
          fmt::format("--seed {}: the recording has the seed {}; omit --seed", *arguments.seed, *seed));
    arguments.seed = seed;
  }
  for (;;) {
    const int code = run(arguments, options);
    const auto seed = options.live->reset_seed();
    if (!seed) return code;
    arguments.seed = seed;
  }
}

std::optional<int> RunInstead(const CommonArguments& arguments, const ScenarioApp& app) {
  if (PrintsInstead(arguments, app)) return kRan;
  if (!arguments.figure.empty()) return RunFigure(app, arguments);
  return {};
}

bool PrintsInstead(const CommonArguments& arguments, const ScenarioApp& app) {
  if (arguments.list)
    for (const auto& [name, description] : ListScenarios(app.name))
      fmt::print("{:<16} {}\n", name, description);
  if (arguments.keys) {
    std::optional<YamlDocument> scenario;
    if (!arguments.scenario.empty()) scenario = LoadScenario(arguments, app.name);
    if (scenario && app.check) app.check(*scenario);
    if (scenario) scenario = scenario->WithAbsolutePaths();
    std::vector<ScenarioKey> keys = app.keys();
    for (const auto& [name, kind, known] : app.files) {
      std::string file = scenario ? scenario->Value(name) : "";
      if (const auto key = std::ranges::find(keys, name, &ScenarioKey::key);
          file.empty() && key != keys.end())
        file = key->initial;
      for (ScenarioKey& inner : KeysOfFile(kind, {file}, name, known ? known() : std::vector<ScenarioKey>()))
        keys.push_back(std::move(inner));
    }
    PrintKeys(keys);
  }
  return arguments.list || arguments.keys;
}

FieldList AppScenario::With(FieldList own) {
  own.insert(own.begin(),
             {{"duration_s", &AppScenario::duration_s}, {"log_rate_hz", &AppScenario::log_rate_hz}});
  return CommonScenario::With(own);
}

int RunApp(const ScenarioApp& app, int argc, char** argv) {
  CommandLine line(app.description, ProgramName(argv));
  CommonArguments arguments;
  AddAppArguments(line, app, arguments);
  return RunMain(line, argc, argv, [&]() -> int {
    if (const auto code = RunInstead(arguments, app)) return *code;
    return RunLive(arguments, [&](const CommonArguments& now, const RunOptions& options) {
      const YamlDocument document = LoadScenario(now, app.name);
      if (app.warnings)
        for (const std::string& warning : app.warnings(document)) Say(fmt::format("warning: {}\n", warning));
      return PrintResult(app.run(document, now.duration, options).summary, options);
    });
  });
}

}  // namespace tenon::apps
