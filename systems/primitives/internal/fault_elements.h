#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <cstddef>
#include <string>
#include <vector>

namespace tenon::internal {

/// Which of a signal's elements `names` mean, as indices in order: by the names that logs show, or how these
/// begin up to a dot ("q" is all of "q.0", "q.1", …). No name means all. With `real_only` what is a bool, an
/// integer or an enumeration is left out, and refused if it is named. Throws ParameterError if there is no
/// element of a name, or none at all.
std::vector<std::size_t> FindElements(const std::vector<Element>& elements,
                                      const std::vector<std::string>& names, bool real_only);

/// Throws RunError unless a signal has as many numbers as its fault was made for.
void CheckCount(std::size_t found, std::size_t expected);

/// All numbers of a value into memory of that size.
template <class T>
void CopyElements(const T& value, std::vector<double>& numbers) {
  CheckCount(CountScalars(TypeInfoOf<T>(), &value), numbers.size());
  ToDoubles(TypeInfoOf<T>(), &value, numbers.data());
}

/// Does `change(number, i)` to those numbers of `value` that are chosen; `numbers` is memory of its size.
template <class T, class Change>
void ChangeElements(T& value, const std::vector<std::size_t>& chosen, std::vector<double>& numbers,
                    Change change) {
  CopyElements(value, numbers);
  for (const std::size_t i : chosen) change(numbers[i], i);
  FromDoubles(TypeInfoOf<T>(), &value, numbers.data());
}

}  // namespace tenon::internal
