#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <tenon/systems/yaml/yaml.h>

namespace tenon::apps {

/// What every app returns to the shell. What a signal stops returns 128 and its number, as in a shell: 130
/// after Ctrl-C, 143 after SIGTERM.
enum ExitCode {
  kRan = 0,
  kBadUsage = 2,          ///< command line, scenario or robot file
  kLimitBroken = 3,       ///< the robot fell, or broke a limit that the scenario forbids to break
  kNumericalFailure = 4,  ///< or out of memory
  kOutputFailed = 5,      ///< a file could not be written
};

/// The arguments that all apps share.
struct CommonArguments {
  std::string scenario;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> settings;  ///< key=value
  std::optional<double> duration;     ///< [s]
  std::string out;                    ///< directory; empty: out/SCENARIO
  std::string graph;                  ///< file; empty: none
  bool list = false;
};

/// Declares the shared arguments on an app's command line; the app may add its own.
void AddCommonArguments(CLI::App& app, CommonArguments& arguments);

/// On stderr; what cannot be told there is lost, and nothing else with it.
void Say(const std::string& text) noexcept;

/// What a run leaves, and how long it may take.
struct RunOptions {
  std::filesystem::path out;              ///< directory; empty: no file and no progress, figures alone
  std::string graph = {};                 ///< file; empty: none
  std::optional<double> wall_limit = {};  ///< [s] on the clock
};

/// Where the run writes: --out, or out/SCENARIO; and --graph.
RunOptions OptionsOf(const CommonArguments& arguments);

/// Parses the command line, runs `body`, and turns errors into a message on stderr and an exit code.
int RunMain(CLI::App& app, int argc, char** argv, const std::function<int()>& body);

/// A scenario file with all `settings`, key=value, applied. `extends: NAME` in a scenario takes over
/// everything of another that it does not say itself; lists are taken over as a whole. Throws ParameterError,
/// among others for a scenario of another app than `app`.
YamlDocument LoadScenario(const std::string& name, const std::vector<std::string>& settings,
                          const std::string& app);
/// The same of a command line, with its seed; what the scenario leaves to chance is drawn by that.
YamlDocument LoadScenario(const CommonArguments& arguments, const std::string& app);
/// Gives a scenario its seed, if there is one, and draws what it leaves to chance. Returns what was drawn.
std::vector<std::pair<std::string, double>> DrawScenario(YamlDocument& scenario,
                                                         std::optional<std::uint64_t> seed);

/// Prints name and description of every shipped scenario whose `app` key is this app's name.
void ListScenarios(const std::string& app);

}  // namespace tenon::apps
