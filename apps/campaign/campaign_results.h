#pragma once

#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/apps/common/scenario_app.h>

namespace tenon::apps {

/// Evaluates the table of a campaign: writes report.html and summary.json beside it and prints a summary on
/// stdout. `schedule` holds the limits found; `command` is the command line that repeats a run, without the
/// run's number. Throws OutputError.
void WriteResults(const CampaignPlan& plan, const CampaignSchedule& schedule, const std::string& command,
                  const std::filesystem::path& directory);

/// Quotes a text for a shell, in the commands that repeat runs.
std::string ShellQuoted(const std::string& text);

/// Returns the output directory of a repeated run.
std::filesystem::path ReplayDirectory(const std::filesystem::path& directory, std::size_t run);

/// Searches for the values of `optimise` at which the campaign costs least, and compares the best with the
/// first values on the seeds that are held back. A third of the evaluations are points of Sobol's sequence;
/// the rest is a local search of NLopt from the best of them: BOBYQA (Powell, report DAMTP NA06, Cambridge,
/// 2009), or with constraints or a single key COBYLA (Powell 1994). Both use values alone, no derivatives.
///
/// Each evaluation is a campaign on all cores with its own table `evaluations/N.csv`. search.csv receives a
/// line for each evaluation, summary.json and report.html are written at the end. `resume` continues a search
/// from these files and finds what an uninterrupted search finds. Prints each evaluation on stdout. Returns
/// an ExitCode, kLimitBroken if no values let all runs finish within the constraints, or 128 plus the number
/// of a signal. Throws ParameterError for a figure that no run has, and OutputError.
int SearchCampaign(const YamlDocument& file, const ScenarioApp& app, const std::filesystem::path& directory,
                   int jobs, bool resume);

}  // namespace tenon::apps
