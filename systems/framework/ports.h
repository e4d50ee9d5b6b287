#pragma once

#include <deque>
#include <optional>
#include <type_traits>
#include <utility>

#include <tenon/systems/framework/calculation.h>
#include <tenon/systems/framework/system.h>

namespace tenon {

template <class T>
class ContinuousState;
template <class T>
class DiscreteState;
class Subdiagram;

/// A value that a block reads. Must be connected, unless it has a default. `T` is any copyable type.
template <class T>
class InputPort : public Source {
 public:
  using Value = T;
  using Argument = const T&;

  InputPort(System* owner, Spec spec)
      : Source(owner, SourceKind::kInput, std::move(spec), internal::kTypeInfo<T>, &model_) {}
  /// Optional: reads as `unconnected` if nothing is connected.
  InputPort(System* owner, Spec spec, T unconnected) : InputPort(owner, std::move(spec)) {
    model_ = std::move(unconnected);
    SetHasInitialValue();
  }

 private:
  T model_ = internal::Zeroed<T>();
};

/// A source that has a calculation.
template <class T>
class Calculated : public Source {
 protected:
  Calculated(System* owner, SourceKind kind, Spec spec)
      : Source(owner, kind, std::move(spec), internal::kTypeInfo<T>, &model_) {}

  template <class... H, class F>
  void Calculate(UsesList<H...> uses, F function) {
    using Code = internal::Calculation<T, F, H...>;
    std::vector<Slot> slots;
    std::apply([&](const auto&... handle) { (handle.Append(slots), ...); }, uses.handles);
    SetCalculation(&Code::Run, std::make_shared<Code>(Code{&owner(), std::move(function), std::move(uses)}),
                   std::move(slots));
  }

  T model_ = internal::Zeroed<T>();
};

/// A value that a block provides.
///
/// Without Sampled it is a function of time, states and inputs, computed when somebody needs it. With
/// Sampled{rate} it is computed at its ticks and held between; at a tick all due outputs run in dataflow
/// order, so a chain of sampled blocks has no hidden delay. `initial` is the value before the first tick,
/// needed if there is an offset; it also gives the size of values whose size is known at run time only.
template <class T>
class OutputPort : public Calculated<T> {
 public:
  using Value = T;
  using Argument = const T&;

  template <class... H, class F>
  OutputPort(Leaf* owner, Spec spec, UsesList<H...> uses, F function)
      : Calculated<T>(owner, SourceKind::kOutput, std::move(spec)) {
    this->Calculate(std::move(uses), std::move(function));
  }
  template <class... H, class F>
  OutputPort(Leaf* owner, Spec spec, T initial, UsesList<H...> uses, F function)
      : OutputPort(owner, std::move(spec), std::move(uses), std::move(function)) {
    this->model_ = std::move(initial);
  }
  template <class... H, class F>
  OutputPort(Leaf* owner, Spec spec, Sampled sampled, UsesList<H...> uses, F function)
      : OutputPort(owner, std::move(spec), std::move(uses), std::move(function)) {
    this->SetTrigger({Trigger::When::kSampled, sampled, nullptr});
  }
  template <class... H, class F>
  OutputPort(Leaf* owner, Spec spec, T initial, Sampled sampled, UsesList<H...> uses, F function)
      : OutputPort(owner, std::move(spec), sampled, std::move(uses), std::move(function)) {
    this->model_ = std::move(initial);
    this->SetHasInitialValue();
  }
  /// A state, as it is.
  OutputPort(Leaf* owner, const ContinuousState<T>& state) : OutputPort(owner, state, 0) {}
  OutputPort(Leaf* owner, const DiscreteState<T>& state) : OutputPort(owner, state, 0) {}
  /// Of a nested diagram: connect an inner output to it.
  OutputPort(Subdiagram* owner, Spec spec);

 private:
  OutputPort(Leaf* owner, const Source& state, int)
      : Calculated<T>(owner, SourceKind::kOutput, state.spec()) {
    this->SetDriver(state);
  }
};

/// The values of an InputPorts list, as its calculation receives them.
template <class T>
class Inputs {
 public:
  Inputs(const std::byte* memory, const internal::Offset* offsets, std::size_t size)
      : memory_(memory), offsets_(offsets), size_(size) {}
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return *reinterpret_cast<const T*>(memory_ + offsets_[i]); }

 private:
  const std::byte* memory_;
  const internal::Offset* offsets_;
  std::size_t size_;
};

/// A list of input ports whose number is known at run time only; they are named `name_0`, `name_1`, ….
template <class T>
class InputPorts {
 public:
  InputPorts(Leaf* owner, const Spec& spec, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      ports_.emplace_back(owner, Spec{spec.name + "_" + std::to_string(i), spec.units, spec.elements});
    }
  }
  std::size_t size() const { return ports_.size(); }
  InputPort<T>& operator[](std::size_t i) { return ports_.at(i); }
  const InputPort<T>& operator[](std::size_t i) const { return ports_.at(i); }

 private:
  std::deque<InputPort<T>> ports_;
};

template <class T>
struct SourceHandle<InputPorts<T>> {
  const InputPorts<T>* source;
  using Argument = Inputs<T>;
  Argument Load(std::byte* memory, const internal::Offset*& cursor) const {
    const std::size_t size = *cursor++;
    const internal::Offset* offsets = cursor;
    cursor += size;
    return Inputs<T>(memory, offsets, size);
  }
  void Append(std::vector<Source::Slot>& slots) const {
    slots.push_back({Source::Slot::What::kCount, nullptr, static_cast<std::uint32_t>(source->size())});
    for (std::size_t i = 0; i < source->size(); ++i)
      slots.push_back({Source::Slot::What::kSource, &(*source)[i]});
  }
};

}  // namespace tenon
