#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// One value for each cable of the robot. Assigning a vector of equal size does not allocate.
using CableVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign>;

/// Throws RunError if `num`, the number of cables in the input of the block `who`, is not `num_cables`.
void CheckNumCables(int num_cables, Eigen::Index num, const char* who);

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::CableVector);
