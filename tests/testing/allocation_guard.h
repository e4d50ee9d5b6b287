#pragma once

namespace tenon {

/// Counts the heap allocations of the present thread during its lifetime: by operator new, malloc, calloc,
/// realloc, and the aligned functions, which Eigen uses.
///
///     AllocationGuard guard;
///     simulator.RunTo(1);
///     EXPECT_EQ(guard.count(), 0);
///
/// Linking tenon::allocation_guard replaces malloc by a function that counts and calls the C library's. With
/// a sanitizer, which has its own malloc, or without glibc, nothing is counted.
class AllocationGuard {
 public:
  AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;

  /// Allocations since the guard was made; 0 if not Available().
  long count() const;
  /// True if allocations are counted in this build. Tests that expect allocations skip themselves otherwise.
  static bool Available();

 private:
  long start_;
};

/// Heap allocations of the present thread during `call`; 0 if they are not counted in this build:
///
///     EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(1); }), 0);
template <class F>
long AllocationsOf(const F& call) {
  const AllocationGuard guard;
  call();
  return guard.count();
}

}  // namespace tenon
