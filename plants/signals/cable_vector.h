#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <Eigen/Core>

namespace tenon {

/// One value per cable, of which there are as many as the description says. Assigning to a vector of the same
/// size does not allocate.
using CableVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign>;

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::CableVector);
