#include <tenon/systems/simulation/real_time_thread.h>

#include <fmt/core.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

namespace tenon {
namespace {

constexpr int kPriority = 80;  // of 1 to 99; interrupts of a kernel with PREEMPT_RT have 50

/// The other threads of this program.
std::vector<pid_t> OtherThreads() {
  std::vector<pid_t> threads;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task", ignored))
    if (const pid_t id = std::stoi(entry.path().filename()); id != gettid()) threads.push_back(id);
  return threads;
}

/// Sets the scheduling of a thread, 0 for the calling one; returns whether that is permitted. Threads that it
/// starts do not inherit it.
bool Schedule(pid_t thread, int policy, int priority) {
  const sched_param param{priority};
  return sched_setscheduler(thread, policy | SCHED_RESET_ON_FORK, &param) == 0;
}

/// Sets the processors of all threads that are started later, unless they set them themselves.
void SetProcessorsOfLaterThreads(const cpu_set_t& processors) {
  pthread_attr_t later;
  if (pthread_getattr_default_np(&later) != 0) return;
  pthread_attr_setaffinity_np(&later, sizeof processors, &processors);
  pthread_setattr_default_np(&later);
  pthread_attr_destroy(&later);
}

/// With a limit of locked memory, later allocations would fail.
bool LockMemory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  return (geteuid() == 0 || limit.rlim_cur == RLIM_INFINITY) && mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

std::string Remedy(const char* limit) {
  return fmt::format(
      "add a line `USER - {}` with your name to /etc/security/limits.d/tenon.conf and log in again", limit);
}

}  // namespace

struct RealTimeThread::Before {
  cpu_set_t processors{};
  bool scheduled = false, bound = false, locked = false;
};

RealTimeThread::RealTimeThread(int processor) : before_(std::make_unique<Before>()) {
  Before& now = *before_;
  now.locked = LockMemory();
  if (!now.locked)
    refused_.push_back("memory may be paged out, because this user may not lock it: " +
                       Remedy("memlock unlimited"));
  const std::vector<pid_t> others = OtherThreads();
  sched_getaffinity(0, sizeof now.processors, &now.processors);
  if (CPU_COUNT(&now.processors) >= std::max(2, processor + 1)) {
    cpu_set_t own, rest = now.processors;
    CPU_ZERO(&own);
    for (int last = CPU_SETSIZE - 1, left = processor; CPU_COUNT(&own) == 0; --last)
      if (CPU_ISSET(last, &now.processors) && left-- == 0) CPU_SET(last, &own), CPU_CLR(last, &rest);
    now.bound = sched_setaffinity(0, sizeof own, &own) == 0;
    SetProcessorsOfLaterThreads(rest);
    for (const pid_t thread : others) sched_setaffinity(thread, sizeof rest, &rest);
  }
  if (!now.bound)
    refused_.push_back(
        fmt::format("the thread of control shares its processor with others, because this program may use {} "
                    "of them: use a machine with more, or `taskset` with more",
                    CPU_COUNT(&now.processors)));

  now.scheduled = Schedule(0, SCHED_FIFO, kPriority);
  for (const pid_t thread : others) Schedule(thread, SCHED_FIFO, kPriority - 1);
  if (!now.scheduled)
    refused_.push_back("the thread of control has no real-time priority, which this user may not set: " +
                       Remedy("rtprio 90"));
}

RealTimeThread::~RealTimeThread() {
  std::vector<pid_t> threads = OtherThreads();
  threads.push_back(0);
  for (const pid_t thread : threads) {
    if (before_->scheduled) Schedule(thread, SCHED_OTHER, 0);
    if (before_->bound) sched_setaffinity(thread, sizeof before_->processors, &before_->processors);
  }
  if (before_->bound) SetProcessorsOfLaterThreads(before_->processors);
  if (before_->locked) munlockall();
}

}  // namespace tenon
