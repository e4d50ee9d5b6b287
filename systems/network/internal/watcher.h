#pragma once

#include <functional>
#include <thread>

namespace tenon::internal {

/// Calls a function in a separate thread whenever a file descriptor is readable, until the function returns
/// false or the watcher is destroyed. Does nothing if the system cannot create a thread.
class Watcher {
 public:
  Watcher(int file, std::function<bool()> read);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

 private:
  int stop_;  ///< becomes readable to end the thread
  std::thread thread_;
};

}  // namespace tenon::internal
