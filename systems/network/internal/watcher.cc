#include <tenon/systems/io/internal/no_signals.h>
#include <tenon/systems/network/internal/watcher.h>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <system_error>
#include <utility>

namespace tenon::internal {

Watcher::Watcher(int file, std::function<bool()> read) : stop_(eventfd(0, EFD_CLOEXEC)) {
  if (stop_ < 0) return;
  try {
    const NoSignals no_signals;
    thread_ = std::thread([file, stop = stop_, read = std::move(read)] {
      for (;;) {
        std::array<pollfd, 2> files{pollfd{file, POLLIN, 0}, pollfd{stop, POLLIN, 0}};
        if (poll(files.data(), files.size(), -1) < 0) continue;
        if (files[1].revents != 0 || !read()) return;
      }
    });
  } catch (const std::system_error&) {
  }
}

Watcher::~Watcher() {
  if (thread_.joinable()) {
    eventfd_write(stop_, 1);
    thread_.join();
  }
  if (stop_ >= 0) close(stop_);
}

}  // namespace tenon::internal
