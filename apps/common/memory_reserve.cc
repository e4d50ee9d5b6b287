#include <tenon/apps/common/memory_reserve.h>

#include <cstddef>
#include <cstdlib>
#include <new>

namespace tenon::apps {

std::atomic<void*> MemoryReserve::most_ = nullptr, MemoryReserve::rest_ = nullptr;

namespace {

constexpr std::size_t kMost = 16 << 20, kRest = 2 << 20;  // [bytes]; writing a report needs a few MB
constexpr std::size_t kLeastMost = 4 << 20, kLeastRest = 1 << 18, kStack = 1 << 19;

void PutAside(std::atomic<void*>& part, std::size_t size, std::size_t least) {
  for (; size >= least && part == nullptr; size /= 2) {
    void* none = nullptr;
    void* const memory = std::malloc(size);
    if (!part.compare_exchange_strong(none, memory)) std::free(memory);
  }
}

/// Touches stack pages, which then stay mapped: growing the stack without memory would crash the process.
[[gnu::noinline]] void GrowStack() {
  [[maybe_unused]] volatile char some[kStack];
  for (std::size_t i = 0; i < kStack; i += 1024) some[i] = 0;
}

}  // namespace

MemoryReserve::MemoryReserve() : before_(std::set_new_handler(OnNoMemory)) {
  GrowStack();
  Refill();
}

MemoryReserve::~MemoryReserve() {
  std::set_new_handler(before_);
  for (auto* const part : {&most_, &rest_}) std::free(part->exchange(nullptr));
}

bool MemoryReserve::lives() noexcept {
  return std::get_new_handler() == OnNoMemory;
}

void MemoryReserve::Refill() noexcept {
  if (!lives()) return;
  PutAside(rest_, kRest, kLeastRest);
  PutAside(most_, kMost, kLeastMost);
}

bool MemoryReserve::given() noexcept {
  return lives() && most_ == nullptr;
}

/// The std::new_handler; returning makes operator new retry.
void MemoryReserve::OnNoMemory() {
  if (void* const most = most_.exchange(nullptr)) return std::free(most);
  std::free(rest_.exchange(nullptr));
  throw std::bad_alloc();
}

}  // namespace tenon::apps
