#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

#include <tenon/systems/framework/ports.h>
#include <tenon/systems/framework/state.h>
#include <tenon/systems/framework/system.h>

namespace tenon {

class Diagram;

namespace internal {

/// What DiagramBuilder and Subdiagram share: blocks, and connections between them.
class Assembly {
 public:
  Assembly(const Assembly&) = delete;
  Assembly& operator=(const Assembly&) = delete;

  /// Makes a block and adds it under `name`. Throws BuildError if the name is taken or holds a dot or a
  /// blank, ParameterError (with the block's name in front) if the block refuses its parameters.
  template <std::derived_from<System> Block, class... Args>
  Block& Add(std::string name, Args&&... args) {
    CheckName(name);
    try {
      return static_cast<Block&>(Adopt(std::make_unique<Block>(std::forward<Args>(args)...), name));
    } catch (...) {
      RethrowWithName(name);
    }
  }

  /// Connects an output to an input, an own input of a nested diagram to an inner input, or an inner output
  /// to an own output. Throws BuildError if `to` has a connection already, or a port belongs elsewhere.
  template <class From, class To>
  void Connect(const From& from, To& to) {
    static_assert(std::is_same_v<typename From::Value, typename To::Value>,
                  "Connect: the two ports carry different types.");
    Join(from, to);
  }

  /// Adds a block that is one function of the values it uses, connects it to them, and returns its output.
  /// `Uses(builder.time, plant.state)` may name outputs of other blocks and own inputs.
  template <class... S, class F>
  auto& AddFunction(Spec spec, UsesList<SourceHandle<S>...> uses, F function) {
    return AddFunctionBlock(std::move(spec), uses, std::move(function));
  }
  /// The same, sampled.
  template <class... S, class F>
  auto& AddFunction(Spec spec, Sampled sampled, UsesList<SourceHandle<S>...> uses, F function) {
    return AddFunctionBlock(std::move(spec), uses, std::move(function), sampled);
  }

  const std::vector<std::unique_ptr<System>>& blocks() const { return blocks_; }

  const Time time{};

 protected:
  explicit Assembly(System* self) : self_(self) {}
  ~Assembly() = default;
  std::vector<std::unique_ptr<System>> TakeBlocks() {
    by_name_.clear();
    return std::move(blocks_);
  }

 private:
  friend class Compiler;

  template <class... S, class F, class... When>
  auto& AddFunctionBlock(Spec spec, const UsesList<SourceHandle<S>...>& uses, F function, When... when);
  void CheckName(const std::string& name) const;
  System& Adopt(std::unique_ptr<System> block, const std::string& name);
  void Join(const Source& from, Source& to);
  [[noreturn]] static void RethrowWithName(const std::string& name);

  System* self_;  ///< the subdiagram, or null at top level
  std::vector<std::unique_ptr<System>> blocks_;
  std::unordered_map<std::string, const System*> by_name_;  ///< the same
};

/// The input of a function block that stands for one used port; `time` needs none.
template <class Port>
struct FunctionInput {
  FunctionInput(Leaf* owner, const Port& port, std::size_t index)
      : input(std::make_unique<InputPort<typename Port::Value>>(
            owner, Spec("input_" + std::to_string(index), port.spec().units, port.spec().elements))) {}
  const auto& source() const { return *input; }
  std::unique_ptr<InputPort<typename Port::Value>> input;
};
template <>
struct FunctionInput<Time> {
  FunctionInput(Leaf* owner, const Time&, std::size_t) : time(&owner->time) {}
  const Time& source() const { return *time; }
  const Time* time;
};

/// The block behind AddFunction.
template <class R, class F, class... S>
class FunctionBlock final : public Leaf {
 public:
  template <class... When>
  FunctionBlock(Spec spec, const std::tuple<SourceHandle<S>...>& used, F function, When... when)
      : inputs(MakeInputs(used, std::index_sequence_for<S...>{})),
        output(this, Spec("output", spec.units, spec.elements), when...,
               std::apply([](const auto&... input) { return Uses(input.source()...); }, inputs),
               std::move(function)) {}

  std::tuple<FunctionInput<S>...> inputs;
  OutputPort<R> output;

 private:
  template <std::size_t... I>
  std::tuple<FunctionInput<S>...> MakeInputs(const std::tuple<SourceHandle<S>...>& used,
                                             std::index_sequence<I...>) {
    return {FunctionInput<S>(this, *std::get<I>(used).source, I)...};
  }
};

template <class... S, class F, class... When>
auto& Assembly::AddFunctionBlock(Spec spec, const UsesList<SourceHandle<S>...>& uses, F function,
                                 When... when) {
  using R = std::remove_cvref_t<std::invoke_result_t<const F&, typename SourceHandle<S>::Argument...>>;
  auto& block = Add<FunctionBlock<R, F, S...>>(spec.name, spec, uses.handles, std::move(function), when...);
  const auto connect = [&]<class Port>(const SourceHandle<Port>& used, FunctionInput<Port>& input) {
    if constexpr (!std::is_same_v<Port, Time>) Connect(*used.source, *input.input);
  };
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (connect(std::get<I>(uses.handles), std::get<I>(block.inputs)), ...);
  }
  (std::index_sequence_for<S...>{});
  return block.output;
}

}  // namespace internal

/// Collects blocks and connections, and compiles them into a Diagram.
class DiagramBuilder : public internal::Assembly {
 public:
  DiagramBuilder() : Assembly(nullptr) {}
  /// Checks and compiles the diagram; the builder is empty afterwards, while references to blocks stay good.
  /// Throws BuildError: unconnected inputs, algebraic loops (with every hop), states without derivative,
  /// offsets without initial value.
  std::unique_ptr<Diagram> Build();
  /// The same, but leaves inputs that are not connected open, to be fixed by hand in each context.
  std::unique_ptr<Diagram> BuildWithOpenInputs();
};

/// A block made of blocks. Derive from it, declare ports as members, and add and connect inside the
/// constructor; its own ports serve as ends of connections from both sides.
class Subdiagram : public System, public internal::Assembly {
 public:
  Subdiagram() : Assembly(this) {}
};

template <class T>
OutputPort<T>::OutputPort(Subdiagram* owner, Spec spec)
    : Calculated<T>(owner, SourceKind::kOutput, std::move(spec)) {}

}  // namespace tenon
