#pragma once

#include <tenon/systems/framework/block/state.h>

#include <string>
#include <type_traits>

namespace tenon {

struct MultiportSwitchParams {
  int count = 2;              ///< number of signals
  std::string unit = "";      ///< unit of the signals and of the output
  std::string elements = "";  ///< names of the elements
  void Validate() const { Demand(count >= 1, "count must be 1 or more: it is " + std::to_string(count)); }
};

/// Selects one of several signals by its index:
///
///     y = u[select]
///
///     | port       | kind   | size   | unit |
///     | select     | input  | Index  |      |
///     | u[0], …    | input  | T each | unit |
///     | y          | output | T      | unit |
///
/// T is any copyable type; Index is an integer or an enumeration. All inputs have feedthrough. The selection
/// is a Kink. Throws ParameterError if count is below 1, and RunError if `select` is out of range.
template <class T = double, class Index = int>
class MultiportSwitch final : public LeafSystem<MultiportSwitchParams> {
  static_assert(std::is_integral_v<Index> || std::is_enum_v<Index>,
                "MultiportSwitch: Index is an integer or an enumeration.");

 public:
  using LeafSystem::LeafSystem;
  InputPort<Index> select{this, "select"};
  InputPorts<T> u{this, {"u", params.unit, params.elements}, static_cast<std::size_t>(params.count)};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Uses(select, u),
                  [](const Index& select, const Inputs<T>& u) -> const T& {
                    const auto i = static_cast<long long>(select);
                    if (i < 0 || static_cast<std::size_t>(i) >= u.size()) {
                      throw RunError("select is " + std::to_string(i) + ", but the " +
                                     std::to_string(u.size()) + " signals are numbered from 0 to " +
                                     std::to_string(u.size() - 1));
                    }
                    return u[static_cast<std::size_t>(i)];
                  }};
  Kink kink{this, "kink", Uses(select),
            [](const Index& select) { return static_cast<std::int64_t>(select); }};
};

}  // namespace tenon
