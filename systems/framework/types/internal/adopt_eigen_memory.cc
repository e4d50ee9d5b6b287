// Part of each shared library, whose calls of malloc, calloc, realloc and free the linker redirects to here
// (--wrap); calls of other libraries, such as those of operator new, are not redirected. Thus practically all
// of this memory is Eigen's. After AdoptEigenMemory() it has the form that Eigen's handmade_aligned_malloc
// gives it: aligned, and the word before it holds the pointer that malloc returned. A program of which Eigen
// uses vectors of more than 16 bytes, or a sanitizer, allocates and frees in this form only.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace tenon::internal {
extern std::atomic<bool> eigen_memory_is_adopted, eigen_memory_is_in_use;
}

extern "C" {

// The names are those of the linker.
void* __real_malloc(std::size_t size);                     // NOLINT
void* __real_calloc(std::size_t count, std::size_t size);  // NOLINT
void* __real_realloc(void* memory, std::size_t size);      // NOLINT
void __real_free(void* memory);                            // NOLINT

}  // extern "C"

namespace {

constexpr std::size_t kAlignment = 64;  // the largest vector's

bool IsAdopted() {
  return tenon::internal::eigen_memory_is_adopted.load(std::memory_order_relaxed);
}

/// Notes that memory in the form of malloc exists.
void* Noted(void* memory) {
  if (!tenon::internal::eigen_memory_is_in_use.load(std::memory_order_relaxed)) {
    tenon::internal::eigen_memory_is_in_use.store(true, std::memory_order_relaxed);
  }
  return memory;
}

std::size_t Padded(std::size_t size) {
  return size > SIZE_MAX - kAlignment ? size : size + kAlignment;
}

void*& Whole(void* memory) {
  return *(static_cast<void**>(memory) - 1);
}

void* AlignedIn(void* whole) {
  return reinterpret_cast<void*>((reinterpret_cast<std::uintptr_t>(whole) / kAlignment + 1) * kAlignment);
}

void* Placed(void* whole) {
  if (whole == nullptr) return nullptr;
  void* const memory = AlignedIn(whole);
  Whole(memory) = whole;
  return memory;
}

}  // namespace

extern "C" {

void* __wrap_malloc(std::size_t size) {  // NOLINT
  return IsAdopted() ? Placed(__real_malloc(Padded(size))) : Noted(__real_malloc(size));
}

void* __wrap_calloc(std::size_t count, std::size_t size) {  // NOLINT
  if (!IsAdopted()) return Noted(__real_calloc(count, size));
  std::size_t total = 0;
  if (__builtin_mul_overflow(count, size, &total)) return nullptr;
  return Placed(__real_calloc(1, Padded(total)));
}

void* __wrap_realloc(void* memory, std::size_t size) {  // NOLINT
  if (!IsAdopted()) return Noted(__real_realloc(memory, size));
  if (memory == nullptr) return __wrap_malloc(size);
  const std::ptrdiff_t before = static_cast<char*>(memory) - static_cast<char*>(Whole(memory));
  void* const whole = __real_realloc(Whole(memory), Padded(size));
  if (whole == nullptr) return nullptr;
  void* const moved = AlignedIn(whole);
  std::memmove(moved, static_cast<char*>(whole) + before, size);
  return Placed(whole);
}

void __wrap_free(void* memory) {  // NOLINT
  __real_free(IsAdopted() && memory != nullptr ? Whole(memory) : memory);
}

}  // extern "C"
