#pragma once

#include <tenon/systems/live/live_server.h>

#include <termios.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>

namespace tenon::apps {

/// Steers a live run by the keys of a terminal, and shows how it goes in one line of it. Where stdin is no
/// terminal it does nothing.
///
///     w s a d q e   forward, backward, left, right, turn left, turn right: one notch more
///     space         stop
///     p             pause, or go on       . one tick      b back by a second
///     + -           twice, half as fast
class LiveTerminal {
 public:
  LiveTerminal();   ///< keys come at once from now on
  ~LiveTerminal();  ///< the terminal is as it was
  LiveTerminal(const LiveTerminal&) = delete;
  LiveTerminal& operator=(const LiveTerminal&) = delete;
  /// Reads the keys that wait; to be called often, in the thread of the run.
  void Poll(LiveServer& server);
  /// What a key means; public for tests.
  void Press(char key, LiveServer& server);
  /// The line.
  std::string Line(const LiveStatus& status) const;

 private:
  void Send(LiveServer& server, const std::string& command);
  std::optional<termios> before_;
  std::array<double, 3> velocity_{};  ///< forward [m/s], left [m/s], yaw [rad/s]
  double rate_ = 1;
  std::string answer_;
  std::chrono::steady_clock::time_point shown_{};
};

}  // namespace tenon::apps
