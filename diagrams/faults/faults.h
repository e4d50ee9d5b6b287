#pragma once

#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/primitives/signal_fault.h>

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tenon {

/// The kinds of SignalFaultKind under the same names, and `broken` for mechanical parts.
enum class FaultKind { kDropOut, kStuck, kNan, kSpike, kOffset, kLoss, kLate, kLost, kBroken };
constexpr auto EnumNames(FaultKind) {
  using enum FaultKind;
  return std::array{Named{kDropOut, "drop_out"}, Named{kStuck, "stuck"},   Named{kNan, "nan"},
                    Named{kSpike, "spike"},      Named{kOffset, "offset"}, Named{kLoss, "loss"},
                    Named{kLate, "late"},        Named{kLost, "lost"},     Named{kBroken, "broken"}};
}

/// A fault of a signal or of a mechanical part, without its place. A number that the kind does not use must
/// not be given, see SignalFault.
struct Fault {
  FaultKind kind = FaultKind::kDropOut;    ///< type of the fault
  std::vector<std::string> elements = {};  ///< names of elements of the signal, joints or cables; empty: all
  double start_s = 0;                      ///< start time of the fault
  std::optional<double> duration_s;        ///< duration of the fault; empty: until the end of the run
  std::optional<double> size;      ///< size of spike and offset [unit of the signal], or of loss: 1 loses all
  std::optional<double> period_s;  ///< period of spikes; empty: a single spike
  std::optional<int> samples;      ///< delay of `late` in ticks
  std::optional<double> probability;  ///< probability of `lost` at each tick

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError

  FaultSchedule schedule() const {
    return {start_s, duration_s.value_or(std::numeric_limits<double>::infinity())};
  }
  /// Indices of `elements` in `parts`; `type` names a part in the message. Throws ParameterError for an
  /// unknown name.
  std::vector<int> Indices(const char* type, const std::vector<Element>& parts) const;
};

/// A fault at one of the places of a robot.
template <NamedEnum Place>
struct FaultAt : Fault {
  Place at{};  ///< signal or mechanical part at which the fault occurs
  static FieldList Fields() {
    FieldList fields{Required("at", &FaultAt::at)};
    for (const Field& field : Fault::Fields()) fields.push_back(field);
    return fields;
  }
};

/// Error for a fault that is not possible in the diagram.
class FaultError : public ParameterError {
 public:
  FaultError(std::size_t index, const std::string& what) : ParameterError(what), index_(index) {}
  std::size_t index() const { return index_; }  ///< index of the fault in its list

 private:
  std::size_t index_;
};

/// Adds fault blocks to a diagram, under the names fault_0, fault_1, ….
class FaultInserter {
 public:
  explicit FaultInserter(DiagramBuilder& builder) : builder(builder) {}
  DiagramBuilder& builder;
  std::vector<const Source*> signals;  ///< `acting` of each fault, and the signal that it changes

  /// Calls insert(fault, name) for each fault. Throws FaultError for a fault that `insert` refuses, and
  /// ParameterError for more than 100 faults.
  template <NamedEnum Place>
  void InsertAll(const std::vector<FaultAt<Place>>& faults, const auto& insert) {
    CheckCount(faults.size());
    for (std::size_t i = 0; i < faults.size(); ++i)
      InsertOne(i, EnumName(faults[i].at), [&](const std::string& name) { insert(faults[i], name); });
  }

 private:
  static void CheckCount(std::size_t count);
  static void InsertOne(std::size_t index, const char* place,
                        const std::function<void(const std::string& name)>& insert);
};

/// The mechanical faults of one plant in a chain: each block merges its own faults with those of the block
/// before it, and the last block feeds the plant.
template <class T>
class FaultChain {
 public:
  explicit FaultChain(InputPort<T>& plant) : plant_(&plant) {}
  /// Adds a block at the end of the chain by its ports `faults` and `others`.
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

/// Throws ParameterError unless the fault's kind is one of `possible`.
void DemandKind(const Fault& fault, const std::vector<FaultKind>& possible);

namespace internal {

/// Throws ParameterError if the period of a spike is shorter than the sample period.
void DemandPeriod(const Fault& fault, const Rate& rate);
/// Throws ParameterError if the fault's kind is for mechanical parts only.
SignalFaultKind SignalKind(const Fault& fault);
/// Throws ParameterError because no block reads the signal; `reason` says why, and names the remedy.
[[noreturn]] void ThrowUnread(const char* reason);

}  // namespace internal

/// A place where a signal can fail: the connections of an output to some of its readers.
template <class T>
class FaultPoint {
 public:
  /// Constructs a place that the diagram does not have: Insert throws an error with this reason.
  explicit FaultPoint(const char* reason) : reason_(reason) {}
  FaultPoint(const OutputPort<T>& output, std::vector<InputPort<T>*> readers, Rate rate,
             T initial = internal::Zeroed<T>())
      : output_(&output), readers_(std::move(readers)), rate_(rate), initial_(initial) {}

  /// Inserts a fault after the existing ones. Throws ParameterError.
  void Insert(FaultInserter& inserter, const Fault& fault, const std::string& name) {
    if (output_ == nullptr) internal::ThrowUnread(reason_);
    internal::DemandPeriod(fault, rate_);
    const SignalFaultParams<T> defaults;
    auto& block = inserter.builder.Add<SignalFault<T>>(
        name, {.kind = internal::SignalKind(fault),
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
  const char* reason_ = "";
  const OutputPort<T>* output_ = nullptr;
  std::vector<InputPort<T>*> readers_;
  Rate rate_ = Hz(1000);
  T initial_ = internal::Zeroed<T>();
};

}  // namespace tenon
