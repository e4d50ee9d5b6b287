#pragma once

#include <tenon/systems/block.h>

namespace tenon {

struct SwitchParams {
  std::string unit = "";      ///< unit of the two signals and the output
  std::string elements = "";  ///< names of the elements
};

/// Selects one of two signals by a bool:
///
///     y = on if select, else off
///
/// T is any copyable type. All inputs have feedthrough. The selection is a Kink.
template <class T = double>
class Switch final : public LeafSystem<SwitchParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<bool> select{this, "select"};
  InputPort<T> on{this, {"on", params.unit, params.elements}};
  InputPort<T> off{this, {"off", params.unit, params.elements}};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Uses(select, on, off),
                  [](bool first, const T& a, const T& b) -> const T& { return first ? a : b; }};
  Kink kink{this, "kink", Uses(select), [](bool first) { return std::int64_t{first}; }};
};

struct ThresholdSwitchParams {
  double threshold = 0;           ///< [control_unit]
  std::string control_unit = "";  ///< unit of the control input
  std::string unit = "";          ///< unit of the two signals and the output
  std::string elements = "";      ///< names of the elements
};

/// Selects one of two signals by comparing a number with a threshold:
///
///     y = on if control >= threshold, else off
///
/// T is any copyable type. All inputs have feedthrough. The selection is a Kink. Throws ParameterError if the
/// threshold is not finite.
template <class T = double>
class ThresholdSwitch final : public LeafSystem<ThresholdSwitchParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<double> threshold{
      this, {"threshold", params.control_unit}, params.threshold, "threshold of control", Range().Finite()};
  InputPort<double> control{this, {"control", params.control_unit}};
  InputPort<T> on{this, {"on", params.unit, params.elements}};
  InputPort<T> off{this, {"off", params.unit, params.elements}};
  OutputPort<T> y{
      this,
      {"y", params.unit, params.elements},
      Uses(control, threshold, on, off),
      [](double c, double level, const T& a, const T& b) -> const T& { return c >= level ? a : b; }};
  Kink kink{this, "kink", Uses(control, threshold),
            [](double c, double level) { return std::int64_t{c >= level}; }};
};

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
                  [](const Index& select_now, const Inputs<T>& u_now) -> const T& {
                    const auto i = static_cast<long long>(select_now);
                    if (i < 0 || static_cast<std::size_t>(i) >= u_now.size()) {
                      throw RunError("select is " + std::to_string(i) + ", but the " +
                                     std::to_string(u_now.size()) + " signals are numbered from 0 to " +
                                     std::to_string(u_now.size() - 1));
                    }
                    return u_now[static_cast<std::size_t>(i)];
                  }};
  Kink kink{this, "kink", Uses(select),
            [](const Index& select_now) { return static_cast<std::int64_t>(select_now); }};
};

}  // namespace tenon
