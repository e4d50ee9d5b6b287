#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon::internal {

/// Returns the indices, in order, of a signal's elements named in `names`: by their names in logs, or by the
/// beginning of a name up to a dot ("q" for "q.0", "q.1", …). No name means all elements. With `real_only`,
/// elements that are a bool, an integer or an enumeration are omitted, and rejected if named. Throws
/// ParameterError if a name matches no element, or none remains.
std::vector<std::size_t> FindElements(const std::vector<Element>& elements,
                                      const std::vector<std::string>& names, bool real_only);

/// Throws RunError if a signal does not have the number of elements that its fault expects.
void CheckCount(std::size_t found, std::size_t expected);

/// Copies all numbers of `value` into memory of that size.
template <class T>
void CopyElements(const T& value, std::vector<double>& numbers) {
  CheckCount(CountScalars(TypeInfoOf<T>(), &value), numbers.size());
  ToDoubles(TypeInfoOf<T>(), &value, numbers.data());
}

/// Calls `change(number, i)` for the chosen numbers of `value`; `numbers` is memory of the same size.
template <class T, class Change>
void ChangeElements(T& value, const std::vector<std::size_t>& chosen, std::vector<double>& numbers,
                    Change change) {
  CopyElements(value, numbers);
  for (const std::size_t i : chosen) change(numbers[i], i);
  FromDoubles(TypeInfoOf<T>(), &value, numbers.data());
}

}  // namespace tenon::internal
