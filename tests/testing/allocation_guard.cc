#include <tenon/tests/testing/allocation_guard.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define TENON_SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TENON_SANITIZED
#endif

#if defined(__GLIBC__) && !defined(TENON_SANITIZED)
#define TENON_COUNTS_ALLOCATIONS true
#else
#define TENON_COUNTS_ALLOCATIONS false
#endif

namespace {

// Initial-exec: finding the counter must not itself allocate.
[[gnu::tls_model("initial-exec")]] thread_local long allocations = 0;

}  // namespace

namespace tenon {

AllocationGuard::AllocationGuard() : start_(allocations) {}
long AllocationGuard::count() const {
  return allocations - start_;
}
bool AllocationGuard::Available() {
  return TENON_COUNTS_ALLOCATIONS;
}

}  // namespace tenon

#if TENON_COUNTS_ALLOCATIONS
// The memory still comes from the C library's heap, so its own free() serves for all of it.
extern "C" {

void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* old, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  ++allocations;
  return __libc_calloc(count, size);
}

void* realloc(void* old, std::size_t size) noexcept {
  ++allocations;
  return __libc_realloc(old, size);
}

void* memalign(std::size_t alignment, std::size_t size) noexcept {
  ++allocations;
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++allocations;
  return __libc_memalign(alignment, size);
}

int posix_memalign(void** out, std::size_t alignment, std::size_t size) noexcept {
  if (alignment % sizeof(void*) != 0 || alignment == 0 || (alignment & (alignment - 1)) != 0) return EINVAL;
  ++allocations;
  void* memory = __libc_memalign(alignment, size);
  if (memory == nullptr) return ENOMEM;
  *out = memory;
  return 0;
}

}  // extern "C"
#endif
