#pragma once

#include <Eigen/Core>

namespace tenon::apps {

// What scenarios demand of their numbers; all throw ParameterError with the key.

void DemandPositive(const char* key, double value);     ///< and finite
void DemandNotNegative(const char* key, double value);  ///< and finite
void DemandRate(const char* key, double hz);            ///< what Hz() takes, and no more than 100 kHz
void DemandSamplePeriod(const char* key, double s);     ///< what Seconds() takes, of a rate as above
void DemandBetween(const char* key, double value, double low, double high);  ///< or one of them
void DemandNear(const char* key, const Eigen::Vector3d& place_m);  ///< within 100 m: beyond is no robot

}  // namespace tenon::apps
