#pragma once

#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/primitives/signal_fault.h>

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

/// The kinds of SignalFaultKind, with the same names, and kBroken for mechanical parts.
enum class FaultKind { kDropOut, kStuck, kNan, kSpike, kOffset, kLoss, kLate, kLost, kBroken };
constexpr auto EnumNames(FaultKind) {
  using enum FaultKind;
  return std::array{Named{kDropOut, "drop_out"}, Named{kStuck, "stuck"},   Named{kNan, "nan"},
                    Named{kSpike, "spike"},      Named{kOffset, "offset"}, Named{kLoss, "loss"},
                    Named{kLate, "late"},        Named{kLost, "lost"},     Named{kBroken, "broken"}};
}

/// A fault in a scenario, without its place. Keys that the kind does not use are refused, see SignalFault.
struct Fault {
  FaultKind kind = FaultKind::kDropOut;  ///< the kind of fault
  std::vector<std::string> elements =
      {};                            ///< affected elements, joints or cables, named as in logs; empty: all
  double start_s = 0;                ///< start of the fault
  std::optional<double> duration_s;  ///< default: until the end of the run
  std::optional<double> size;        ///< size of a spike or offset [the signal's unit], or lost share, 0 to 1
  std::optional<double> period_s;    ///< period of spikes; default: a single spike
  std::optional<int> samples;        ///< delay of kind late [ticks]
  std::optional<double> probability;  ///< probability of a loss at each tick, of kind lost

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError

  FaultSchedule schedule() const {
    return {start_s, duration_s.value_or(std::numeric_limits<double>::infinity())};
  }
  /// Returns the indices of `elements` in `things`. Throws ParameterError, which calls a thing `what`.
  std::vector<int> Indices(const char* what, const std::vector<Element>& things) const;
};

/// A fault with its place in the robot.
template <NamedEnum Place>
struct FaultScenario : Fault {
  Place at{};  ///< the signal or part that fails
  static FieldList Fields() {
    FieldList fields{Required("at", &FaultScenario::at)};
    for (const Field& field : Fault::Fields()) fields.push_back(field);
    return fields;
  }
};

/// Inserts the faults of a scenario into a diagram as blocks fault_0, fault_1, ….
class FaultInserter {
 public:
  explicit FaultInserter(DiagramBuilder& builder) : builder(builder) {}
  DiagramBuilder& builder;
  std::vector<const Source*> signals;  ///< for logs: activity and output of each fault

  /// Calls insert(fault, name) for each fault. Throws KeyError with the key of a fault that cannot be
  /// inserted, or for more than 100 faults.
  template <NamedEnum Place>
  void InsertAll(const std::vector<FaultScenario<Place>>& faults, const auto& insert) {
    CheckCount(faults.size());
    for (std::size_t i = 0; i < faults.size(); ++i)
      WithKey(i, EnumName(faults[i].at), [&] { insert(faults[i], "fault_" + std::to_string(i)); });
  }

 private:
  static void CheckCount(std::size_t count);
  static void WithKey(std::size_t index, const char* place, const std::function<void()>& insert);
};

/// The mechanical faults of one robot in series: each block adds to the faults of its predecessor, and the
/// last one is connected to the plant.
template <class T>
class FaultChain {
 public:
  explicit FaultChain(InputPort<T>& plant) : plant_(&plant) {}
  /// Appends a block by its output and the input for the faults before it.
  void Append(DiagramBuilder& builder, const OutputPort<T>& faults, InputPort<T>& others) {
    if (last_ != nullptr) {
      builder.Disconnect(*plant_);
      builder.Connect(*last_, others);
    }
    builder.Connect(faults, *plant_);
    last_ = &faults;
  }

 private:
  InputPort<T>* plant_;
  const OutputPort<T>* last_ = nullptr;
};

/// Throws ParameterError unless the kind of the fault is one of `possible`.
void DemandKind(const Fault& fault, const std::vector<FaultKind>& possible);
/// Throws ParameterError if the period of spikes is below the signal's sample period.
void DemandPeriod(const Fault& fault, const Rate& rate);
/// Returns the kind as a SignalFaultKind. Throws ParameterError for a mechanical fault.
SignalFaultKind SignalKind(const Fault& fault);
/// Throws ParameterError because no block of the diagram reads the signal.
[[noreturn]] void ThrowUnread(const char* remedy);

/// A place where a signal can fail, between an output and some of its readers.
template <class T>
class FaultPoint {
 public:
  /// A signal without readers in the diagram. Insert throws an error that suggests `remedy`.
  explicit FaultPoint(const char* remedy) : remedy_(remedy) {}
  FaultPoint(const OutputPort<T>& output, std::vector<InputPort<T>*> readers, Rate rate,
             T initial = internal::Zeroed<T>())
      : output_(&output), readers_(std::move(readers)), rate_(rate), initial_(initial) {}

  /// Inserts a fault after those inserted before.
  void Insert(FaultInserter& inserter, const Fault& fault, const std::string& name) {
    if (output_ == nullptr) ThrowUnread(remedy_);
    DemandPeriod(fault, rate_);
    const SignalFaultParams<T> defaults;
    auto& block = inserter.builder.Add<SignalFault<T>>(
        name, {.kind = SignalKind(fault),
               .schedule = fault.schedule(),
               .affected = fault.elements,
               .size = fault.size.value_or(defaults.size),
               .period = fault.period_s.value_or(defaults.period),
               .samples = fault.samples.value_or(defaults.samples),
               .probability = fault.probability.value_or(defaults.probability),
               .initial = initial_,
               .rate = rate_,
               .unit = output_->spec().units,
               .elements = output_->spec().elements});
    inserter.builder.Connect(*output_, block.u);
    for (InputPort<T>* reader : readers_) {
      inserter.builder.Disconnect(*reader);
      inserter.builder.Connect(block.y, *reader);
    }
    output_ = &block.y;
    inserter.signals.insert(inserter.signals.end(), {&block.acting, &block.y});
  }

 private:
  const char* remedy_ = "";
  const OutputPort<T>* output_ = nullptr;
  std::vector<InputPort<T>*> readers_;
  Rate rate_ = Hz(1000);
  T initial_ = internal::Zeroed<T>();
};

}  // namespace tenon::apps
