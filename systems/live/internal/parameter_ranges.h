#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/context/context.h>

#include <limits>
#include <vector>

namespace tenon::internal {

/// What an element of a Parameter may be; infinite where nothing bounds it, or nothing is known.
struct ParameterRange {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
};

/// The ranges that the elements of a Parameter may be in, about their present values and with all else as it
/// is: found by trying what its block refuses, to six digits. `context` is a copy to try it on; it is left as
/// it was. What has no real number, or takes longer than 1 ms to try once, has no range.
std::vector<ParameterRange> RangesOf(const ParameterSource& parameter, Context& context);

}  // namespace tenon::internal
