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

/// The command-line arguments that all apps share.
struct CommonArguments {
  std::string scenario;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> settings;  ///< key=value
  std::optional<double> duration;     ///< [s]
  std::string out;                    ///< output directory; empty: out/SCENARIO
  std::string graph;                  ///< file of the diagram's graph; empty: none
  std::string live;                   ///< port; empty: not live
  std::string live_address;           ///< address to listen at; empty: this machine only
  std::string replay;                 ///< recording of a live run; empty: none
  bool list = false;
  bool keys = false;
};

/// Adds the arguments that select a scenario to an app's command line.
void AddScenarioArguments(CLI::App& app, CommonArguments& arguments);

/// Adds the arguments that select a scenario and those of its output.
void AddCommonArguments(CLI::App& app, CommonArguments& arguments);

/// Adds --live, --live-address and --replay, for apps that run one scenario.
void AddLiveArguments(CLI::App& app, CommonArguments& arguments);

/// Returns the output directory, --out or out/SCENARIO, and the file of --graph.
RunOptions OptionsOf(const CommonArguments& arguments);

/// Validators of an option's number, with messages that describe the valid range in words.
CLI::Validator Positive();
CLI::Validator PositiveInteger();
CLI::Validator Seed();

/// Parses the command line, runs `body`, and turns errors into a message on stderr and an exit code.
int RunMain(CLI::App& app, int argc, char** argv, const std::function<int()>& body);

/// The file name of the program.
std::string ProgramName(char** argv);

/// Loads the scenario of a command line and draws its random values by the seed.
YamlDocument LoadScenario(const CommonArguments& arguments, const std::string& app);

/// Calls `run` with the arguments and the options of the command line once, and with --live once more for
/// each reset, which changes the seed. A replay uses the seed of the recording. Returns the last exit code.
int RunLive(CommonArguments arguments,
            const std::function<int(const CommonArguments& arguments, const RunOptions& options)>& run);

/// Prints the list of --list or --keys. Returns whether the command line has one of them.
bool PrintsInstead(const CommonArguments& arguments, const ScenarioApp& app);

}  // namespace tenon::apps
