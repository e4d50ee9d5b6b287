#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace tenon::apps {

/// Which column of a log holds a signal; throws Error if none does.
std::size_t Column(const std::vector<std::string>& names, const std::string& signal);
/// Which columns hold the elements of a signal; throws Error if none do.
std::vector<std::size_t> Columns(const std::vector<std::string>& names, const std::string& signal);

/// The vector in these columns of a row.
template <int N>
Vec<N> VectorIn(std::span<const double> row, const std::vector<std::size_t>& columns) {
  Vec<N> value;
  for (int i = 0; i < N; ++i) value[i] = row[columns[static_cast<std::size_t>(i)]];
  return value;
}

}  // namespace tenon::apps
