#pragma once

#include <sundials/sundials_nvector.h>

namespace tenon::internal {

/// Gives a serial vector, and those that are cloned from it, faster forms of what explicit Runge-Kutta steps
/// consist of: sums of vectors in one pass, copies, and the weighted root mean square norm.
///
/// Sums are added in SUNDIALS's order; the norm adds its squares in eight interleaved sums, so that it does
/// not wait for each addition, on every machine in the same order.
void UseFastOperations(N_Vector vector);

}  // namespace tenon::internal
