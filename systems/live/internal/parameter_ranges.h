#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/context/context.h>

#include <limits>
#include <vector>

namespace tenon::internal {

/// The range of an element of a Parameter; infinite if it is unbounded or unknown.
struct ParameterRange {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
};

/// Returns the ranges of a Parameter's elements around their present values with all other values fixed. They
/// are found to six digits by trying which values the block refuses. `context` is a copy for the trials and
/// is left unchanged. Elements that are not real numbers, and Parameters whose trials take longer than 1 ms,
/// have no range.
std::vector<ParameterRange> RangesOf(const ParameterSource& parameter, Context& context);

}  // namespace tenon::internal
