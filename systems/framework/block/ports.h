#pragma once

#include <tenon/systems/framework/block/system.h>

namespace tenon {

template <class T>
class ContinuousState;
template <class T>
class DiscreteState;
class Subdiagram;

/// The size of a vector or matrix that an input must have, where the type leaves it to the run time:
/// `InputPort<Eigen::VectorXd> u{this, "u", OfSize{6}}`.
struct OfSize {
  explicit OfSize(Eigen::Index r, Eigen::Index c = 1) : rows(r), cols(c) {}
  Eigen::Index rows, cols;
};

/// A value that a block reads. It must be connected unless it has a default. `T` is any copyable type.
template <class T>
class InputPort : public Source {
 public:
  using Value = T;
  using Argument = const T&;

  InputPort(System* owner, Spec spec)
      : Source(owner, SourceKind::kInput, std::move(spec), internal::TypeInfoOf<T>(), &model_) {}
  /// An optional input, whose value is `unconnected` if nothing is connected.
  InputPort(System* owner, Spec spec, T unconnected) : InputPort(owner, std::move(spec)) {
    model_ = std::move(unconnected);
    SetHasInitialValue();
  }
  /// An input that takes only values of one size: others are refused by Build, or when they are computed.
  InputPort(System* owner, Spec spec, OfSize size) requires internal::kHasRunTimeSize<T>
      : InputPort(owner, std::move(spec)) {
    model_ = T::Zero(size.rows, size.cols);
  }

 private:
  T model_ = internal::Zeroed<T>();
};

/// A source that has a calculation.
template <class T>
class Calculated : public Source {
 public:
  /// Constructors without Uses(...), which report that it is missing.
  template <class... Args>
  requires internal::kLacksUses<Args...> Calculated(System* owner, Spec spec, const Args&...)
      : Calculated(owner, SourceKind::kOutput, std::move(spec)) {
    internal::ReportMissingUses<UsesList<Args...>>();
  }
  template <class... Args>
  requires internal::kLacksUses<Args...> Calculated(const Source&, const Args&...)
      : Calculated(nullptr, SourceKind::kOutput, Spec("")) {
    internal::ReportMissingUses<UsesList<Args...>>();
  }

 protected:
  Calculated(System* owner, SourceKind kind, Spec spec)
      : Source(owner, kind, std::move(spec), internal::TypeInfoOf<T>(), &model_) {}

  /// `tag` is the TagOf<F> evaluated where the calculation was declared.
  template <class... A, class F>
  void Calculate(UsesList<A...> uses, F function, std::uint64_t tag) {
    this->CheckUses(uses.undeclared, tag != internal::TagOf<F>::value);
    using Code = internal::Calculation<T, F, A...>;
    if constexpr ((std::is_same_v<A, internal::Refused> || ...)) {
      // Uses has already reported the error.
    } else if constexpr (!Code::Traits::kConst || Code::IsMutable()) {
      static_assert(
          internal::kFalse<F>,
          "A calculation must be const, and a lambda not `mutable`: all that changes is kept in the "
          "context, in a DiscreteState or a Scratch.");
    } else if constexpr (!Code::Returns() && !Code::FillsInPlace()) {
      static_assert(internal::kFalse<F>,
                    "The function's parameters must be exactly the values of Uses(...), in that order.");
    } else {
      if constexpr (Code::Returns()) {
        static_assert(Code::ReturnsTarget(),
                      "The function must return exactly the type of the port, state or shared value; the "
                      "function of a Publish returns nothing.");
      }
      SetCalculation(Code::Run(std::index_sequence_for<A...>{}), std::move(function), std::move(uses.slots));
    }
  }

  T model_ = internal::Zeroed<T>();
};

/// A value that a block provides.
///
/// Without Sampled, the value is a function of time, states and inputs, computed on demand. With
/// Sampled{rate} it is computed at its ticks and held between them. At a tick all due outputs run in dataflow
/// order, so a chain of sampled blocks has no hidden delay. `initial` is the value before the first tick,
/// needed if there is an offset. For a vector or matrix of run-time size it declares the size, and an
/// evaluation that gives another one is refused.
template <class T>
class OutputPort : public Calculated<T> {
 public:
  using Value = T;
  using Argument = const T&;
  using Calculated<T>::Calculated;

  template <class... A, class F>
  OutputPort(Leaf* owner, Spec spec, UsesList<A...> uses, F function,
             std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<T>(owner, SourceKind::kOutput, std::move(spec)) {
    this->Calculate(std::move(uses), std::move(function), tag);
  }
  template <class... A, class F>
  OutputPort(Leaf* owner, Spec spec, T initial, UsesList<A...> uses, F function,
             std::uint64_t tag = internal::TagOf<F>::value)
      : OutputPort(owner, std::move(spec), std::move(uses), std::move(function), tag) {
    this->model_ = std::move(initial);
  }
  template <class... A, class F>
  OutputPort(Leaf* owner, Spec spec, Sampled sampled, UsesList<A...> uses, F function,
             std::uint64_t tag = internal::TagOf<F>::value)
      : OutputPort(owner, std::move(spec), std::move(uses), std::move(function), tag) {
    this->SetTrigger(sampled);
  }
  template <class... A, class F>
  OutputPort(Leaf* owner, Spec spec, T initial, Sampled sampled, UsesList<A...> uses, F function,
             std::uint64_t tag = internal::TagOf<F>::value)
      : OutputPort(owner, std::move(spec), sampled, std::move(uses), std::move(function), tag) {
    this->model_ = std::move(initial);
    this->SetHasInitialValue();
  }
  /// An output whose value is a state, with the state's name.
  OutputPort(Leaf* owner, const ContinuousState<T>& state) : OutputPort(owner, state, Spec("")) {}
  OutputPort(Leaf* owner, const DiscreteState<T>& state) : OutputPort(owner, state, Spec("")) {}
  /// An output whose value is a state, with its own name. Units and element names that `spec` omits are the
  /// state's.
  OutputPort(Leaf* owner, Spec spec, const ContinuousState<T>& state)
      : OutputPort(owner, state, std::move(spec)) {}
  OutputPort(Leaf* owner, Spec spec, const DiscreteState<T>& state)
      : OutputPort(owner, state, std::move(spec)) {}
  /// An output of a Subdiagram: connect an inner output to it.
  OutputPort(Subdiagram* owner, Spec spec);

 private:
  OutputPort(Leaf* owner, const Source& state, Spec spec)
      : Calculated<T>(
            owner, SourceKind::kOutput,
            internal::Completed(std::move(spec),
                                internal::CheckDeclared(state, "an OutputPort that shows a state").spec())) {
    this->SetDriver(state);
  }
};

/// The values of an InputPorts list, as its calculation receives them.
template <class T>
class Inputs {
 public:
  Inputs(const std::byte* memory, const internal::Offset* list, const Source&)
      : memory_(memory), offsets_(list + 1), size_(*list) {}
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return *reinterpret_cast<const T*>(memory_ + offsets_[i]); }

 private:
  const std::byte* memory_;
  const internal::Offset* offsets_;
  std::size_t size_;
};

/// A list of input ports whose number is known only at run time; they are named `name_0`, `name_1`, ….
template <class T>
class InputPorts : public internal::Declared {
 public:
  using Argument = Inputs<T>;

  InputPorts(Leaf* owner, const Spec& spec, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      ports_.push_back(std::make_unique<InputPort<T>>(
          owner, Spec{spec.name + "_" + std::to_string(i), spec.units, spec.elements}));
    }
  }
  std::size_t size() const { return ports_.size(); }
  InputPort<T>& operator[](std::size_t i) { return *ports_.at(i); }
  const InputPort<T>& operator[](std::size_t i) const { return *ports_.at(i); }
  void AppendTo(std::vector<internal::Slot>& slots) const {
    slots.push_back({internal::Slot::What::kList, nullptr, static_cast<std::uint32_t>(size())});
    for (const auto& port : ports_) port->AppendTo(slots);
  }

 private:
  std::vector<std::unique_ptr<InputPort<T>>> ports_;
};

}  // namespace tenon
