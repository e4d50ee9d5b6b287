#pragma once

#include <atomic>

namespace tenon::apps {

/// Memory put aside for when there is no more. Who finds none is given most of it, so that what goes on can
/// be ended in good order; who finds none again gets a std::bad_alloc, and what cleans up after that the
/// rest: destructors, as those of nlohmann::json, may take memory, too. While one lives, in all threads, as
/// the process has but one std::new_handler.
class MemoryReserve {
 public:
  MemoryReserve();
  ~MemoryReserve();
  MemoryReserve(const MemoryReserve&) = delete;
  MemoryReserve& operator=(const MemoryReserve&) = delete;
  /// Puts aside again what was given, or less of it if there is no more. Nothing where none lives.
  static void Refill() noexcept;
  /// Whether one lives and was given: it is time to end.
  static bool given() noexcept;

 private:
  static void OnNoMemory();
  static bool lives() noexcept;
  static std::atomic<void*> most_, rest_;
  void (*before_)();
};

}  // namespace tenon::apps
