#pragma once

#include <functional>
#include <thread>

namespace tenon::internal {

/// Calls a function in a thread of its own whenever there is something to read from a file descriptor, until
/// it returns false or the watcher is destroyed. Does nothing if the system has no thread to give.
class Watcher {
 public:
  Watcher(int file, std::function<bool()> read);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

 private:
  int stop_;  ///< readable when the thread is to end
  std::thread thread_;
};

}  // namespace tenon::internal
