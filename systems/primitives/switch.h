#pragma once

#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>

#include <string>

namespace tenon {

struct SwitchParams {
  std::string unit = "";      ///< unit of the two signals and the output
  std::string elements = "";  ///< names of the elements
};

/// Selects one of two signals by a bool:
///
///     y = on if select, else off
///
///     | port    | kind   | size | unit |
///     | select  | input  | bool |      |
///     | on, off | input  | T    | unit |
///     | y       | output | T    | unit |
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
                  [](bool select, const T& on, const T& off) -> const T& { return select ? on : off; }};
  Kink kink{this, "kink", Uses(select), [](bool select) { return std::int64_t{select}; }};
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
///     | port      | kind      | size   | unit         |
///     | control   | input     | double | control_unit |
///     | threshold | Parameter | double | control_unit |
///     | on, off   | input     | T      | unit         |
///     | y         | output    | T      | unit         |
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
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Uses(control, threshold, on, off),
                  [](double control, double threshold, const T& on, const T& off) -> const T& {
                    return control >= threshold ? on : off;
                  }};
  Kink kink{this, "kink", Uses(control, threshold),
            [](double control, double threshold) { return std::int64_t{control >= threshold}; }};
};

}  // namespace tenon
