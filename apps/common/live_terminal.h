#pragma once

#include <tenon/systems/live/live_server.h>

#include <termios.h>

#include <array>
#include <chrono>
#include <optional>
#include <string>

namespace tenon::apps {

/// Steers a live run by the keys of a terminal and shows its status in one line. Does nothing if stdin is not
/// a terminal.
///
///     w s     increase the velocity by a step forward, backward
///     a d     increase the velocity by a step to the left, to the right
///     q e     increase the yaw rate by a step to the left, to the right
///     space   stop
///     p       pause or resume
///     .       advance by one tick
///     b       go back by one second
///     + -     double or halve the speed of the simulation
class LiveTerminal {
 public:
  LiveTerminal();   ///< sets the terminal to report keys at once
  ~LiveTerminal();  ///< restores the terminal
  LiveTerminal(const LiveTerminal&) = delete;
  LiveTerminal& operator=(const LiveTerminal&) = delete;
  /// Handles pressed keys. Call it often from the thread of the run.
  void Poll(LiveServer& server);
  /// Executes the command of a key; public for tests.
  void Press(char key, LiveServer& server);
  /// Formats the status line.
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
