#pragma once

#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/apps/campaign/campaign_schedule.h>

#include <filesystem>

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

}  // namespace tenon::apps
