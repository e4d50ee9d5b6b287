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

/// Options of an app's run with --live or --replay.
struct LiveSessionOptions {
  int port = 8080;                                   ///< TCP port of the server
  std::string address = "127.0.0.1";                 ///< address at which the server listens
  std::optional<std::filesystem::path> replay = {};  ///< recording to repeat; then no server is started
  std::optional<double> duration = {};  ///< [s]; default: a live run continues until it is stopped
};

/// The server of a live run, or the recording of one. It outlives the run: a reset starts
/// another run with another seed at the same address.
class LiveSession {
 public:
  /// Prints the address on stderr. Throws as LiveServer and LiveRecording::Read do.
  explicit LiveSession(const LiveSessionOptions& options);
  ~LiveSession();

  /// Runs the simulation as apps::Advance does. A live run writes live.jsonl into `out`. A recording without
  /// an end is repeated for `duration` [s].
  RunOutcome Advance(Simulator& simulator, const LiveView& view, double duration,
                     const std::filesystem::path& out);
  /// The seed of the next run, if this one ended by a reset.
  std::optional<std::uint64_t> reset_seed() const;
  /// The seed of the recording, if there is one.
  std::optional<std::uint64_t> replay_seed() const;

 private:
  LiveSessionOptions options_;
  std::optional<LiveRecording> recording_;
  std::unique_ptr<LiveServer> server_;
};

}  // namespace tenon::apps
