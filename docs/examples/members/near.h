#pragma once

#include <cmath>
#include <cstdio>

/// Prints a result; returns true if it equals the closed form within 1e-6.
inline bool Near(const char* name, double value, double closed_form, double tolerance = 1e-6) {
  std::printf("%-16s %.9g, exactly %.9g\n", name, value, closed_form);
  return std::abs(value - closed_form) <= tolerance;
}
