#pragma once

#include <Eigen/Core>

namespace tenon::apps {

// Checks of a scenario's numbers. They throw ParameterError with the key.

void DemandPositive(const char* key, double value);     ///< and finite
void DemandNotNegative(const char* key, double value);  ///< and finite
void DemandRate(const char* key, double hz);            ///< valid for Hz(), and at most 100 kHz
void DemandSamplePeriod(const char* key, double s);     ///< valid for Seconds(), and at least 10 us
void DemandBetween(const char* key, double value, double low, double high);  ///< inclusive
void DemandNear(const char* key, const Eigen::Vector3d& place_m);            ///< each coordinate within 100 m

}  // namespace tenon::apps
