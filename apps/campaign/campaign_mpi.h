#pragma once

#include <tenon/apps/campaign/campaign_desk.h>

namespace tenon::apps {

/// Message of an MPI rank to rank 0 about a completed run.
struct CampaignMessage {
  std::size_t run = 0;
  std::optional<CampaignResult> result;  ///< empty if a signal stopped the run
};

/// Serializes a message for Unpack. Bytes that are not UTF-8 become U+FFFD.
std::string Pack(const CampaignMessage& message);
/// Parses a text of Pack. Throws nlohmann::json::exception for other texts.
CampaignMessage Unpack(const std::string& text);

/// Returns whether mpirun started this process.
bool StartedByMpi();

/// Initializes MPI during its lifetime. Rank 0 has the desk and also executes runs; the other ranks request
/// their runs from it, one ahead of the current run, so that they do not wait for messages.
class MpiSession {
 public:
  /// Throws ParameterError if the program was built without MPI.
  MpiSession();
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }
  /// Executes the campaign with all ranks and `jobs` threads of this process. Call it on rank 0.
  void Lead(CampaignDesk& desk, const CampaignRunner& runner, int jobs);
  /// Executes runs until rank 0 has no more. Call it on the other ranks.
  void Follow(const CampaignRunner& runner);
  /// Ends all processes after an error.
  [[noreturn]] void Abort(int exit_code);

 private:
  int rank_ = 0, size_ = 1;
};

}  // namespace tenon::apps
