#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tenon::apps {

/// Which column of a log holds a signal; throws Error if none does.
std::size_t Column(const std::vector<std::string>& names, const std::string& signal);
/// Which columns hold the elements of a signal; throws Error if none do.
std::vector<std::size_t> Columns(const std::vector<std::string>& names, const std::string& signal);

}  // namespace tenon::apps
