#pragma once

#include <tenon/apps/campaign/campaign_desk.h>
#include <tenon/apps/campaign/campaign_runner.h>

namespace tenon::apps {

/// Whether this process was started by mpirun.
bool StartedByMpi();

/// A process among those that mpirun started, from the first one on to the last; MPI is there as long as it
/// lives. Rank 0 has the desk, and works besides; the others fetch their runs from it, one ahead of the one
/// that they do, so that nobody waits for a message.
class MpiSession {
 public:
  /// Throws ParameterError if this was built without MPI.
  MpiSession();
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }
  /// On rank 0: works through the campaign with all ranks, and `jobs` threads of its own.
  void Lead(CampaignDesk& desk, const CampaignRunner& runner, int jobs);
  /// On the others, until rank 0 has no more.
  void Follow(const CampaignRunner& runner);
  /// Ends all processes, since this one cannot go on.
  [[noreturn]] void Abort(int exit_code);

 private:
  int rank_ = 0, size_ = 1;
};

}  // namespace tenon::apps
