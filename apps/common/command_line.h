#pragma once

#include <tenon/apps/common/run_options.h>
#include <tenon/apps/common/scenario_app.h>
#include <tenon/apps/common/scenario_file.h>

#include <CLI/CLI.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

/// The arguments that all apps share.
struct CommonArguments {
  std::string scenario;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> settings;  ///< key=value
  std::optional<double> duration;     ///< [s]
  std::string out;                    ///< directory; empty: out/SCENARIO
  std::string graph;                  ///< file; empty: none
  std::string live;                   ///< port; empty: not live
  std::string live_address;           ///< empty: this machine alone
  std::string replay;                 ///< recording of a live run; empty: none
  bool list = false;
  bool keys = false;
};

/// Declares the arguments that say which scenario, on an app's command line; the app may add its own.
void AddScenarioArguments(CLI::App& app, CommonArguments& arguments);

/// The same and those of what a run writes.
void AddCommonArguments(CLI::App& app, CommonArguments& arguments);

/// --live, --live-address and --replay, of apps that run one scenario.
void AddLiveArguments(CLI::App& app, CommonArguments& arguments);

/// Where the run writes: --out, or out/SCENARIO; and --graph.
RunOptions OptionsOf(const CommonArguments& arguments);

/// Options that say their range in words, where CLI11 would print its limits to the last digit.
CLI::Validator Positive();
CLI::Validator PositiveInteger();
CLI::Validator Seed();

/// Parses the command line, runs `body`, and turns errors into a message on stderr and an exit code.
int RunMain(CLI::App& app, int argc, char** argv, const std::function<int()>& body);

/// LoadScenario of a command line, with its seed; what the scenario leaves to chance is drawn by that.
YamlDocument LoadScenario(const CommonArguments& arguments, const std::string& app);

/// Runs `run` with the arguments and the options of the command line: once, or with --live once more for each
/// reset, with another seed. A replay has the recording's seed. Returns what the last `run` returns.
int RunLive(CommonArguments arguments,
            const std::function<int(const CommonArguments& arguments, const RunOptions& options)>& run);

/// Whether the command line asks for what an app knows instead of a run, --list or --keys; then it is
/// printed.
bool PrintsInstead(const CommonArguments& arguments, const ScenarioApp& app);

}  // namespace tenon::apps
