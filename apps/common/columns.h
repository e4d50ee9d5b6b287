#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace tenon::apps {

/// Returns the index of the column that holds a signal. Throws Error if there is none.
std::size_t Column(const std::vector<std::string>& names, const std::string& signal);
/// Returns the indices of the columns that hold the elements of a signal. Throws Error if there are none.
std::vector<std::size_t> Columns(const std::vector<std::string>& names, const std::string& signal);

/// Returns the vector in the given columns of a row.
template <int N>
Vec<N> VectorIn(std::span<const double> row, const std::vector<std::size_t>& columns) {
  Vec<N> value;
  for (int i = 0; i < N; ++i) value[i] = row[columns[static_cast<std::size_t>(i)]];
  return value;
}

}  // namespace tenon::apps
