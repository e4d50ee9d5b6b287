#pragma once

#include <atomic>

namespace tenon::apps {

/// A reserve for when the process runs out of memory. The first failed allocation releases most of the
/// reserve, so that the run can end regularly. The next one releases the rest, which destructors such as
/// those of nlohmann::json may need, and throws std::bad_alloc. The reserve serves all threads during the
/// lifetime of the object, because a process has only one std::new_handler.
class MemoryReserve {
 public:
  MemoryReserve();
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;
  /// Restores the reserve as far as memory allows; does nothing if there is no MemoryReserve.
  static void Refill() noexcept;
  /// Returns whether a failed allocation has used the reserve, so that the run should end.
  static bool given() noexcept;

 private:
  static void OnNoMemory();
  static bool lives() noexcept;
  static std::atomic<void*> most_, rest_;
  void (*before_)();
};

}  // namespace tenon::apps
