#include <tenon/apps/common/command_line.h>

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <new>
#include <system_error>

#include <tenon/plants/model/resources.h>
#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/internal/excerpt.h>
#include <tenon/systems/io/output_file.h>

namespace tenon::apps {

void AddCommonArguments(CLI::App& app, CommonArguments& arguments) {
  app.add_option("SCENARIO", arguments.scenario, "name of a shipped scenario (see --list), or a YAML file");
  app.add_option("--seed", arguments.seed, "seed of all random streams");
  app.add_option("--set", arguments.settings, "override a value of the scenario: --set pd.rate_hz=500")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--duration", arguments.duration, "simulated time [s], instead of the scenario's")
      ->check(CLI::PositiveNumber);
  app.add_option("--out", arguments.out, "directory for all output (default: out/SCENARIO)");
  app.add_option("--graph", arguments.graph, "write the diagram to this file, .svg or .dot, and run");
  app.add_flag("--list", arguments.list, "list the shipped scenarios and stop");
  app.footer(
      "Writes report.html, summary.json, signals.csv and scenario.yaml (every default filled in) to the "
      "output directory.\n"
      "Ctrl-C ends a run in good order, all files whole; a second one ends it at once.\n"
      "Exit codes: 0 ran; 2 bad usage or scenario; 3 fell or broke a forbidden limit; 4 numerical failure; "
      "5 a file could not be written; 130, 143 stopped by Ctrl-C, SIGTERM.");
}

void Say(const std::string& text) noexcept {
  std::fputs(text.c_str(), stderr);
}

RunOptions OptionsOf(const CommonArguments& arguments) {
  const auto standard = std::filesystem::path("out") / std::filesystem::path(arguments.scenario).stem();
  return {.out = arguments.out.empty() ? standard : std::filesystem::path(arguments.out),
          .graph = arguments.graph};
}

int RunMain(CLI::App& app, int argc, char** argv, const std::function<int()>& body) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kRan : kBadUsage;
  }
  const auto fail = [&](const char* what, ExitCode code) {
    Say(fmt::format("{}: {}\n", app.get_name(), what));
    return code;
  };
  try {
    for (int i = 1; i < argc; ++i) CheckUtf8(argv[i], fmt::format("argument {} of the command line", i));
    const int code = body();
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      return fail("the figures cannot be printed: is the disk full?", kOutputFailed);
    return code;
  } catch (const OutputError& error) {
    return fail(error.what(), kOutputFailed);
  } catch (const RunError& error) {
    return fail(error.what(), kNumericalFailure);
  } catch (const std::bad_alloc&) {
    return fail("out of memory before the run began: is a robot, a list or a horizon of the scenario huge?",
                kNumericalFailure);
  } catch (const std::system_error& error) {
    return fail(error.what(), kOutputFailed);
  } catch (const std::exception& error) {
    return fail(error.what(), kBadUsage);
  }
}

namespace {

/// A scenario with everything that it takes over from the ones that it extends.
YamlDocument LoadExtended(const std::string& name) {
  YamlDocument document = YamlDocument::Load(FindResource("scenarios", name));
  std::vector<std::string> chain{name};
  for (std::string base; !(base = document.Text("extends")).empty();) {
    if (std::find(chain.begin(), chain.end(), base) != chain.end())
      throw ParameterError(fmt::format("scenario '{}' extends itself by way of '{}': take one 'extends' out",
                                       internal::Excerpt(base), internal::Excerpt(chain.back())));
    chain.push_back(base);
    document.Remove("extends");
    document.AddMissing(YamlDocument::Load(FindResource("scenarios", base)));
  }
  return document;
}

}  // namespace

YamlDocument LoadScenario(const std::string& name, const std::vector<std::string>& settings,
                          const std::string& app) {
  YamlDocument document = LoadExtended(name);
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw ParameterError(fmt::format("--set {}: give it as key=value, say --set pd.rate_hz=500",
                                       internal::Excerpt(setting)));
    }
    document.Set(setting.substr(0, equals), setting.substr(equals + 1));
  }
  if (const std::string other = document.Text("app"); !other.empty() && other != app) {
    throw ParameterError(fmt::format("{0}: '{1}' is a scenario of another app, not of {2}; run {3} {1}",
                                     document.PlaceOf("app"), internal::Excerpt(name), app,
                                     internal::Excerpt(other)));
  }
  return document;
}

YamlDocument LoadScenario(const CommonArguments& arguments, const std::string& app) {
  if (arguments.scenario.empty()) {
    throw ParameterError("no scenario given: name one (see --list), or give a YAML file");
  }
  YamlDocument document = LoadScenario(arguments.scenario, arguments.settings, app);
  DrawScenario(document, arguments.seed);
  return document;
}

std::vector<std::pair<std::string, double>> DrawScenario(YamlDocument& scenario,
                                                         std::optional<std::uint64_t> seed) {
  if (seed) {
    scenario.Set("seed", fmt::format("{}", *seed));
  } else {
    const std::string text = scenario.Text("seed");
    std::uint64_t own =
        1;  // that of a scenario which says none; what is no number is refused when it is read
    std::from_chars(text.data(), text.data() + text.size(), own);
    seed = own;
  }
  return scenario.Draw(*seed);
}

void ListScenarios(const std::string& app) {
  for (const std::string& name : ListResources("scenarios")) {
    const YamlDocument document = LoadExtended(name);
    if (document.Text("app") != app) continue;
    fmt::print("{:<16} {}\n", name, document.Text("description"));
  }
}

}  // namespace tenon::apps
