#pragma once

#include <tenon/systems/framework/types/range.h>

namespace tenon::apps {

// Ranges of a scenario's numbers.

Range Rates();          ///< valid for Hz(), and at most 100 kHz
Range SamplePeriods();  ///< valid for Seconds(), and at least 10 us
Range Places();         ///< each coordinate within 1 km

}  // namespace tenon::apps
