#pragma once

#include <tenon/apps/campaign/campaign_runner.h>
#include <tenon/apps/campaign/campaign_schedule.h>
#include <tenon/apps/campaign/campaign_table.h>
#include <tenon/apps/common/progress.h>

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <optional>
#include <string>

namespace tenon::apps {

/// Where the workers of a campaign get their runs and hand in the results: the one writer of its table, which
/// also shows on stderr how far it is. Any thread may call; a signal, see SignalGuard, or a table that cannot
/// be written closes it.
class CampaignDesk {
 public:
  /// `done`: runs of the schedule that were done before.
  CampaignDesk(CampaignSchedule& schedule, CampaignTable& table, std::size_t done);

  /// A run to do; waits while it depends on others whether there is one. None if the campaign is over.
  std::optional<std::size_t> Take();
  /// The same without waiting; none also if there is none yet.
  std::optional<std::size_t> TryTake();
  void Put(std::size_t run, const std::optional<CampaignResult>& result);
  /// Whether no more runs will be given out.
  bool closed();
  /// Ends the display; throws what closed it, OutputError.
  void Close();

 private:
  bool Stopped() const;
  std::optional<double> Share() const;  ///< of all runs, if it is known how many there will be
  std::string Text() const;

  std::mutex mutex_;
  std::condition_variable changed_;
  CampaignSchedule& schedule_;
  CampaignTable& table_;
  std::exception_ptr failure_;
  bool interrupted_ = false;
  std::size_t before_, ended_ = 0, failures_ = 0;
  ProgressLine line_;
};

/// Runs a campaign in `jobs` threads, until the desk has no more.
void WorkInThreads(CampaignDesk& desk, const CampaignRunner& runner, int jobs);

}  // namespace tenon::apps
