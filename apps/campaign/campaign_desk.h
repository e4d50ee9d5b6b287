#pragma once

#include <tenon/apps/campaign/campaign_runner.h>

#include <condition_variable>

namespace tenon::apps {

/// Distributes the runs of a campaign to workers, writes their results to the table and shows the progress on
/// stderr. It is thread-safe. A signal (see SignalGuard), a failed write of the table or a machine that fails
/// one run after the other closes it.
class CampaignDesk {
 public:
  /// `done` is the number of runs that earlier processes completed.
  CampaignDesk(CampaignSchedule& schedule, CampaignTable& table, std::size_t done);

  /// Returns the next run; waits if that depends on results of other runs. Empty at the end of the campaign.
  std::optional<std::size_t> Take();
  /// Returns the next run without waiting; empty also if it depends on results of other runs.
  std::optional<std::size_t> TryTake();
  /// Records the result of a run, empty if a signal stopped it.
  void Put(std::size_t run, const std::optional<CampaignResult>& result);
  /// Returns whether there are no further runs.
  bool closed();
  /// Returns the number of runs that the machine failed, and the last reason.
  std::size_t lost() const { return lost_; }
  const std::string& why_lost() const { return why_lost_; }
  /// Ends the progress display. Rethrows the OutputError that closed the desk.
  void Close();

 private:
  bool Stopped() const { return failure_ || interrupted_ || SignalGuard::caught() != 0; }
  std::optional<double> Share() const;  ///< completed share of all runs, if their number is known
  std::string Text() const;

  std::mutex mutex_;
  std::condition_variable changed_;
  CampaignSchedule& schedule_;
  CampaignTable& table_;
  std::exception_ptr failure_;
  bool interrupted_ = false;
  std::size_t before_, ended_ = 0, failures_ = 0, lost_ = 0, lost_in_a_row_ = 0;
  std::string why_lost_;
  ProgressLine line_;
};

/// Executes runs in `jobs` threads until the desk has no more.
void WorkInThreads(CampaignDesk& desk, const CampaignRunner& runner, int jobs);

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
