#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tenon::internal {

/// Returns the name with the smallest edit distance to `wanted`, for "did you mean"; empty without names.
std::string NearestName(std::string_view wanted, const std::vector<std::string>& names);

}  // namespace tenon::internal
