#pragma once

#include <cfenv>

namespace tenon::internal {

/// Lets floating-point exceptions during its lifetime leave no flags and trap nothing, also in programs that
/// call feenableexcept. For computations that handle infinities and NaN themselves.
class HeldExceptions {
 public:
  HeldExceptions() { std::feholdexcept(&before_); }
  ~HeldExceptions() { std::fesetenv(&before_); }
  HeldExceptions(const HeldExceptions&) = delete;
  HeldExceptions& operator=(const HeldExceptions&) = delete;

 private:
  std::fenv_t before_{};
};

}  // namespace tenon::internal
