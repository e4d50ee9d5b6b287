#pragma once

namespace tenon {

// Checks of numbers under a key. They throw ParameterError with the key and the number.

void DemandPositive(const char* key, double value);                          ///< and finite
void DemandNotNegative(const char* key, double value);                       ///< and finite
void DemandBetween(const char* key, double value, double low, double high);  ///< inclusive

}  // namespace tenon
