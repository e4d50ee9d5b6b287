#pragma once

#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tenon {

class Diagram;

/// Says that a connection is meant though the units differ.
struct IgnoreUnits {};

namespace internal {

template <class Block>
struct ParamsOfBlock {
  using Type = Refused;
};
template <class Block>
requires requires {
  typename Block::Params;
}
struct ParamsOfBlock<Block> {
  using Type = typename Block::Params;
};
/// What a block is made of, if it says so: LeafSystem<P> does, a Subdiagram may by `using Params = …`.
template <class Block>
using ParamsOf = typename ParamsOfBlock<Block>::Type;

/// What DiagramBuilder and Subdiagram share: blocks, and connections between them. As soon as the diagram is
/// built, whatever would change it throws BuildError.
class Assembly {
 public:
  Assembly(const Assembly&) = delete;
  Assembly& operator=(const Assembly&) = delete;

  /// Makes a block and adds it under `name`. Throws BuildError if the name is taken or holds a dot or a
  /// blank, ParameterError (with the block's name in front) if the block refuses its parameters.
  template <class Block, class... Args>
  Block& Add(std::string name, Args&&... args) {
    CheckName(name);
    return static_cast<Block&>(Adopt(Make<Block>(name, std::forward<Args>(args)...), name));
  }
  /// The same with the parameters in braces: `Add<Pd>("pd", {.kp = 3})`.
  template <class Block>
  Block& Add(std::string name, ParamsOf<Block> params) {
    CheckName(name);
    return static_cast<Block&>(Adopt(Make<Block>(name, std::move(params)), name));
  }

  /// Makes a block and puts it in the place of `old`, which may stand at any depth below. It takes over name,
  /// path and place, and the connections of ports with the same name and type; what differs is connected by
  /// hand, and Build says what is left: outputs that somebody reads and the new block lacks, and its inputs
  /// that nothing is connected to. An input that the new block does not have is left away. The old block
  /// stays alive, costs nothing, and is no part of the diagram: whatever is done with its ports is an error.
  template <class Block, class... Args>
  Block& Replace(const System& old, Args&&... args) {
    CheckBelow(old);
    return static_cast<Block&>(Exchange(old, Make<Block>(old.path(), std::forward<Args>(args)...)));
  }
  template <class Block>
  Block& Replace(const System& old, ParamsOf<Block> params) {
    CheckBelow(old);
    return static_cast<Block&>(Exchange(old, Make<Block>(old.path(), std::move(params))));
  }

  /// Puts something between an output and all that read it: `in` reads the output, and what read it reads
  /// `out`. For a delay, a fault, a filter behind a port of a diagram that ships:
  ///
  ///     auto& delay = builder.Add<SampleDelay<Vec<12>>>("delay", {.samples = 3});
  ///     builder.Insert(loop.locomotion.torque, delay.u, delay.y);
  ///
  /// The three may stand at any depth below. Ports of nested diagrams to which the output is connected count
  /// as readers; logs of the output itself show what it was before. Throws BuildError if nothing reads it, or
  /// `in` is connected already.
  template <class From, class In, class Out>
  void Insert(const From& output, In& in, const Out& out) {
    static_assert(std::is_same_v<typename From::Value, typename In::Value> &&
                      std::is_same_v<typename From::Value, typename Out::Value>,
                  "Insert: the three ports carry different types.");
    Splice(output, in, out);
  }

  /// Takes away the connection of an input (or that to an output of a nested diagram, from inside), at any
  /// depth below. Throws BuildError if it has none.
  void Disconnect(Source& input);

  /// Connects an output to an input, an own input of a nested diagram to an inner input, or an inner output
  /// to an own output. A DiagramBuilder also connects ports at any depth, so that what is added to a diagram
  /// that ships finds what it needs. Throws BuildError if `to` has a connection already, or a port belongs
  /// elsewhere.
  template <class From, class To>
  void Connect(const From& from, To& to) {
    static_assert(std::is_same_v<typename From::Value, typename To::Value>,
                  "Connect: the two ports carry different types.");
    Join(from, to);
  }
  /// The same for ports whose units differ on purpose, which Build would refuse.
  template <class From, class To>
  void Connect(const From& from, To& to, IgnoreUnits) {
    Connect(from, to);
    IgnoreUnitsOf(to);
  }

  /// Adds a block that is one function of the values it uses, connects it to them, and returns its output.
  /// `Uses(builder.time, plant.state)` may name outputs of other blocks and own inputs.
  template <class... A, class F>
  auto& AddFunction(Spec spec, UsesList<A...> uses, F function) {
    return MakeFunctionBlock(std::move(spec), uses, std::move(function)).output;
  }
  /// The same for a function that jumps or bends at instants that are known, see NextJump: steps of the
  /// integrator end exactly there.
  ///
  ///     builder.AddFunction({"force", "N"}, JumpsAt{{5, 6}}, Uses(builder.time),
  ///                         [](double t) { return t >= 5 && t < 6 ? 1.0 : 0.0; });
  template <class... A, class F>
  auto& AddFunction(Spec spec, JumpsAt jumps, UsesList<A...> uses, F function) {
    auto& block = MakeFunctionBlock(std::move(spec), uses, std::move(function));
    block.next_jump.emplace(&block, "next_jump", Uses(block.time),
                            [jumps = std::move(jumps)](double time) { return jumps.Next(time); });
    return block.output;
  }
  /// The same, sampled.
  template <class... A, class F>
  auto& AddFunction(Spec spec, Sampled sampled, UsesList<A...> uses, F function) {
    return MakeFunctionBlock(std::move(spec), uses, std::move(function), sampled).output;
  }

  const std::vector<std::unique_ptr<System>>& blocks() const { return blocks_; }

  const Time time{};

 protected:
  explicit Assembly(System* self) : self_(self) {}
  ~Assembly() = default;
  std::vector<std::unique_ptr<System>> TakeBlocks() { return std::move(blocks_); }
  std::vector<std::unique_ptr<System>> TakeReplaced() { return std::move(replaced_); }
  void CheckNotBuilt(const char* call, const std::string& subject) const;
  /// From now on nothing changes it, or a diagram nested in it.
  void MarkBuilt();

 private:
  friend class Compiler;

  template <class... A, class F, class... When>
  auto& MakeFunctionBlock(Spec spec, const UsesList<A...>& uses, F function, When... when);
  template <class Block, class... Args>
  static std::unique_ptr<Block> Make(const std::string& name, Args&&... args) {
    if constexpr (!std::is_base_of_v<System, Block>) {
      static_assert(kFalse<Block>, "Add: what is added must derive from LeafSystem or Subdiagram.");
      throw BuildError("");
    } else if constexpr (!std::is_constructible_v<Block, Args&&...>) {
      static_assert(kFalse<Block>, "Add: these are not the parameters that the block is made of.");
      throw BuildError("");
    } else {
      try {
        return std::make_unique<Block>(std::forward<Args>(args)...);
      } catch (...) {
        RethrowWithName(name);
      }
    }
  }
  void CheckName(const std::string& name) const;
  bool IsBelow(const System& block) const;
  void CheckBelow(const System& block) const;
  void CheckStands(const Source& port) const;
  System& Exchange(const System& old, std::unique_ptr<System> block);
  void Splice(const Source& output, Source& in, const Source& out);
  /// Of all blocks of the whole diagram, as far as it is known here.
  std::vector<Source*> AllSources();
  void AppendSources(std::vector<Source*>& sources);
  System& Adopt(std::unique_ptr<System> block, const std::string& name);
  void Join(const Source& from, Source& to);
  static void IgnoreUnitsOf(Source& to);
  [[noreturn]] static void RethrowWithName(const std::string& name);

  System* self_;  ///< the subdiagram, or null at top level
  bool built_ = false;
  std::vector<std::unique_ptr<System>> blocks_;
  std::unordered_map<std::string, const System*> by_name_;  ///< the same
  std::vector<std::unique_ptr<System>> replaced_;
};

/// The inputs of a function block, one for each port that it uses; `time` needs none.
template <class... A>
class FunctionInputs {
 public:
  FunctionInputs([[maybe_unused]] Leaf* owner, [[maybe_unused]] const std::vector<Slot>& used) {
    (Append<A>(owner, used[uses.slots.size()]), ...);
  }
  UsesList<A...> uses;          ///< of the calculation
  std::vector<Source*> inputs;  ///< null stands for time

 private:
  template <class Argument>
  void Append(Leaf* owner, const Slot& used) {
    if (used.source == nullptr) {
      inputs.push_back(nullptr);
      return owner->time.AppendTo(uses.slots);
    }
    using Input = InputPort<std::remove_cvref_t<Argument>>;
    const Spec& spec = used.source->spec();
    const auto input = std::make_shared<Input>(
        owner, Spec("input_" + std::to_string(inputs.size()), spec.units, spec.elements));
    inputs.push_back(input.get());
    input->AppendTo(uses.slots);
    kept_.push_back(input);
  }
  std::vector<std::shared_ptr<void>> kept_;
};

/// The block behind AddFunction.
template <class R, class F, class... A>
class FunctionBlock final : public Leaf {
 public:
  template <class... When>
  FunctionBlock(Spec spec, const UsesList<A...>& used, F function, When... when)
      : in(this, used.slots),
        output(this, Spec("output", spec.units, spec.elements), when..., in.uses, std::move(function)) {}

  FunctionInputs<A...> in;
  OutputPort<R> output;
  std::optional<NextJump> next_jump = {};
};

template <class... A, class F, class... When>
auto& Assembly::MakeFunctionBlock(Spec spec, const UsesList<A...>& uses, F function, When... when) {
  using R = std::remove_cvref_t<std::invoke_result_t<const F&, A...>>;
  CheckNotBuilt("AddFunction", spec.name);
  if (uses.undeclared > 0) ThrowUndeclared("the function '" + spec.name + "'", "a member");
  auto& block = Add<FunctionBlock<R, F, A...>>(spec.name, spec, uses, std::move(function), when...);
  for (std::size_t i = 0; i < uses.slots.size(); ++i) {
    if (block.in.inputs[i] != nullptr) Join(*uses.slots[i].source, *block.in.inputs[i]);
  }
  return block;
}

}  // namespace internal

/// Collects blocks and connections, and compiles them into a Diagram.
class DiagramBuilder : public internal::Assembly {
 public:
  DiagramBuilder() : Assembly(nullptr) {}
  /// Checks and compiles the diagram, which owns the blocks from then on. The builder is empty and done: Add,
  /// Connect, Build and whatever else would change it throw BuildError, also those of nested diagrams; for
  /// another diagram make another builder.
  ///
  /// Throws BuildError with all faults that it finds: unconnected inputs, units or sizes that differ,
  /// algebraic loops (with every hop), states without derivative, offsets without initial value. Then the
  /// builder is as before: mend the diagram and build again.
  std::shared_ptr<const Diagram> Build();
  /// The same, but leaves inputs that are not connected open, to be fixed by hand in each context.
  std::shared_ptr<const Diagram> BuildWithOpenInputs();

 private:
  std::shared_ptr<const Diagram> Compile(const char* call, bool open_inputs);
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
