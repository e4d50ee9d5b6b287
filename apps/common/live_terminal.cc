#include <tenon/apps/common/live_terminal.h>
#include <tenon/apps/common/progress.h>
#include <tenon/systems/text/excerpt.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace tenon::apps {
namespace {

constexpr const char* kName = "terminal";  // name as a driver
constexpr double kNotch = 0.1;             // step of a velocity [m/s], [rad/s]

}  // namespace

LiveTerminal::LiveTerminal() {
  termios now{};
  // A background process does not own the terminal.
  if (isatty(STDIN_FILENO) == 0 || tcgetpgrp(STDIN_FILENO) != getpgrp() || tcgetattr(STDIN_FILENO, &now) != 0)
    return;
  before_ = now;
  now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  now.c_cc[VMIN] = 0;
  now.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &now);
}

LiveTerminal::~LiveTerminal() {
  if (!before_) return;
  tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
  Say("\n");
}

void LiveTerminal::Poll(LiveServer& server) {
  if (!before_) return;
  pollfd in{STDIN_FILENO, POLLIN, 0};
  char key = 0;
  while (poll(&in, 1, 0) > 0 && read(STDIN_FILENO, &key, 1) == 1) Press(key, server);
  const auto now = std::chrono::steady_clock::now();
  if (now - shown_ < std::chrono::milliseconds(200)) return;
  shown_ = now;
  Draw(fmt::format("\r{}\033[K", internal::Printable(Line(server.status()))));
}

void LiveTerminal::Send(LiveServer& server, const std::string& command) {
  const auto answer = [&](const std::string& json) {
    const auto reply = nlohmann::json::parse(server.Command(kName, json), nullptr, false);
    return reply.is_object() && reply.contains("error") ? reply["error"].get<std::string>() : std::string();
  };
  answer_ = answer(R"({"command":"take","force":true})");
  if (answer_.empty()) answer_ = answer(command);
}

void LiveTerminal::Press(char key, LiveServer& server) {
  const std::string_view kDrive = "wsadqe";
  const std::size_t which = kDrive.find(key);
  if (which != kDrive.npos || key == ' ') {
    const std::array<double, 3> before = velocity_;
    if (key == ' ') {
      velocity_ = {};
    } else {
      double& v = velocity_[which / 2];
      v = std::round((v + (which % 2 == 0 ? kNotch : -kNotch)) / kNotch) * kNotch;
    }
    Send(server, fmt::format(R"({{"command":"drive","velocity":[{},{},{}]}})", velocity_[0], velocity_[1],
                             velocity_[2]));
    if (!answer_.empty()) velocity_ = before;
  } else if (key == 'p') {
    const bool paused = server.status().state == "paused";
    Send(server, paused ? R"({"command":"resume"})" : R"({"command":"pause"})");
  } else if (key == '.') {
    Send(server, R"({"command":"tick"})");
  } else if (key == 'b') {
    Send(server, fmt::format(R"({{"command":"back","to_s":{}}})", std::max(0.0, server.status().time - 1)));
  } else if (key == '+' || key == '-') {
    rate_ = std::clamp(key == '+' ? 2 * rate_ : rate_ / 2, 1.0 / 64, 64.0);
    Send(server, fmt::format(R"({{"command":"rate","value":{}}})", rate_));
  }
}

std::string LiveTerminal::Line(const LiveStatus& status) const {
  std::string line = fmt::format("{:.1f} s  {}  {:.2f}x  {} browser{}", status.time, status.state,
                                 status.rate, status.clients, status.clients == 1 ? "" : "s");
  if (velocity_ != std::array<double, 3>{})
    line += fmt::format("  {:+.1f} {:+.1f} m/s {:+.1f} rad/s", velocity_[0], velocity_[1], velocity_[2]);
  if (!answer_.empty()) line += "  " + answer_.substr(0, 60);
  return line;
}

}  // namespace tenon::apps
