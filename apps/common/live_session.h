#pragma once

#include <tenon/apps/common/progress.h>
#include <tenon/systems/live/live_server.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace tenon::apps {

/// How an app is run with --live or --replay.
struct LiveSessionOptions {
  int port = 8080;
  std::string address = "127.0.0.1";
  std::optional<std::filesystem::path> replay = {};  ///< a recording; then there is no server
  std::optional<double> duration = {};               ///< [s]; without, a live run goes on until it is stopped
};

/// The server of a live run, with the keys of a terminal, or the recording of such a run. It outlives the
/// run: a reset makes another one, of another seed, behind the same address.
class LiveSession {
 public:
  /// Prints the address on stderr. Throws what LiveServer and LiveRecording::Read throw.
  explicit LiveSession(const LiveSessionOptions& options);
  ~LiveSession();

  /// Runs it, and writes live.jsonl into `out` if it is live. `duration` [s] is the scenario's, of a
  /// recording without an end. As apps::Advance.
  RunOutcome Advance(Simulator& simulator, const LiveView& view, double duration,
                     const std::filesystem::path& out);
  /// Whether the run ended to be begun anew, with this seed.
  std::optional<std::uint64_t> reset_seed() const;
  /// Of the recording.
  std::optional<std::uint64_t> replay_seed() const;

 private:
  LiveSessionOptions options_;
  std::optional<LiveRecording> recording_;
  std::unique_ptr<LiveServer> server_;
};

}  // namespace tenon::apps
