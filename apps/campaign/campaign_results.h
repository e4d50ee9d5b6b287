#pragma once

#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/apps/campaign/campaign_schedule.h>

#include <filesystem>
#include <string>

namespace tenon::apps {

/// Makes of the table of a campaign what there is to look at: report.html and summary.json beside it, and
/// some lines on stdout. `schedule` knows what limits were found; `command` is how to run one again, but for
/// its number. Throws OutputError.
void WriteResults(const CampaignPlan& plan, const CampaignSchedule& schedule, const std::string& command,
                  const std::filesystem::path& directory);

/// Where a run that is done again leaves its files.
std::filesystem::path ReplayDirectory(const std::filesystem::path& directory, std::size_t run);

}  // namespace tenon::apps
