#pragma once

#include <sundials/sundials_nvector.h>

namespace tenon::internal {

/// Gives a serial vector and its clones faster operations for explicit Runge-Kutta steps: linear combinations
/// in one pass, copies, and the weighted root-mean-square norm.
///
/// Linear combinations add in SUNDIALS's order. The norm uses eight interleaved partial sums, so that
/// additions do not wait for each other, in the same order on every machine.
void UseFastOperations(N_Vector vector);

}  // namespace tenon::internal
