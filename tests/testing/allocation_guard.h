#pragma once

namespace tenon {

/// Counts the heap allocations of the present thread while it lives, by operator new as by malloc, calloc,
/// realloc and the aligned ones (Eigen's among them):
///
///     AllocationGuard guard;
///     simulator.RunTo(1);
///     EXPECT_EQ(guard.count(), 0);
///
/// Linking tenon::testing replaces malloc by one that counts and passes on to the C library's. Under a
/// sanitizer, which has a malloc of its own, or without glibc nothing is counted.
class AllocationGuard {
 public:
  AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;

  /// Allocations since the guard was made; 0 if not Available().
  long count() const;
  /// Whether allocations are counted in this build: tests that expect some skip themselves if not.
  static bool Available();

 private:
  long start_;
};

}  // namespace tenon
