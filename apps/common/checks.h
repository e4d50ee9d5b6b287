#pragma once

#include <tenon/systems/framework/types/number_checks.h>

#include <Eigen/Core>

namespace tenon::apps {

// Checks of a scenario's numbers. Each one throws ParameterError with the key.

void DemandRate(const char* key, double hz);         ///< valid for Hz(), and at most 100 kHz
void DemandSamplePeriod(const char* key, double s);  ///< valid for Seconds(), and at least 10 us
void DemandNear(const char* key, const Eigen::Vector3d& place_m);  ///< each coordinate within 100 m

}  // namespace tenon::apps
