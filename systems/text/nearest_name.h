#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tenon::internal {

/// The name with the smallest edit distance to `wanted`, for "did you mean"; empty if there are no names.
std::string NearestName(std::string_view wanted, const std::vector<std::string>& names);

}  // namespace tenon::internal
