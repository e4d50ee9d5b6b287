#pragma once

#include <tenon/systems/framework/block/state.h>

#include <unordered_map>

namespace tenon {

class Diagram;

/// Argument of Connect that permits different units.
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
/// The value that AddFunction's function returns.
template <class F, class... A>
using ResultOf = std::remove_cvref_t<std::invoke_result_t<const F&, A...>>;

/// The parameters of a block: LeafSystem<P> defines them, and a Subdiagram may by `using Params = …`.
template <class Block>
using ParamsOf = typename ParamsOfBlock<Block>::Type;

/// Base of DiagramBuilder and Subdiagram: blocks, and connections between them. After the diagram is built,
/// every member that would change it throws BuildError.
class Assembly {
 public:
  Assembly(const Assembly&) = delete;
  Assembly& operator=(const Assembly&) = delete;

  /// Constructs a block and adds it as `name`. Throws BuildError if the name is taken or contains a dot, a
  /// comma or a blank, and ParameterError that begins with the block's name if the block rejects its
  /// parameters.
  template <class Block, class... Args>
  Block& Add(std::string name, Args&&... args) {
    CheckName(name);
    return static_cast<Block&>(Adopt(Make<Block>(name, std::forward<Args>(args)...), name));
  }
  /// Adds a block with its parameters in braces: `Add<Pd>("pd", {.kp = 3})`.
  template <class Block>
  Block& Add(std::string name, ParamsOf<Block> params) {
    CheckName(name);
    return static_cast<Block&>(Adopt(Make<Block>(name, std::move(params)), name));
  }

  /// Constructs a block and replaces `old`, at any depth below, by it. The new block takes over the name, the
  /// position, and the connections of ports with the same name and type. Connect all other ports yourself;
  /// Build reports those that remain: outputs that are read but missing in the new block, and its unconnected
  /// inputs. Connections to inputs that the new block lacks are removed. The old block stays alive at no
  /// run-time cost, but is not part of the diagram: wherever one of its ports is used, in a builder, a
  /// context or a log, the port of the new block with the same name and type is meant, and without one that
  /// is an error. Likewise, replacing a replaced block replaces the one in its place.
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

  /// Inserts a block between an output and all its readers: `in` is connected to the output, and its readers
  /// to `out`. Use it for a delay, a fault or a filter at a port of a shipped diagram:
  ///
  ///     auto& delay = builder.Add<SampleDelay<Vec<12>>>("delay", {.samples = 3});
  ///     builder.Insert(loop.locomotion.torque, delay.u, delay.y);
  ///
  /// All three ports may be at any depth below. Ports of nested diagrams that are connected to the output
  /// count as readers, those in `except` do not; logs of the output itself show its unmodified value. Throws
  /// BuildError if the output has no reader, or `in` is already connected.
  template <class From, class In, class Out>
  void Insert(const From& output, In& in, const Out& out, const std::vector<const Source*>& except = {}) {
    static_assert(std::is_same_v<typename From::Value, typename In::Value> &&
                      std::is_same_v<typename From::Value, typename Out::Value>,
                  "Insert: the three ports have different types.");
    Splice(output, in, out, except);
  }
  /// Inserts a block in front of one input, at any depth below: `in` takes over the connection of `input`, if
  /// it has one, and `input` is connected to `out`.
  template <class T>
  void InsertBefore(InputPort<T>& input, InputPort<T>& in, const OutputPort<T>& out) {
    SpliceBefore(input, in, out);
  }

  /// Removes the connection of an input, or the inner connection of an output of a nested diagram, at any
  /// depth below. Throws BuildError if there is none.
  void Disconnect(Source& input);

  /// Connects an output to an input, an input of a nested diagram to an inner input, or an inner output to an
  /// output of the nested diagram. A DiagramBuilder also connects ports at any depth, so that you can add
  /// blocks to a shipped diagram. Throws BuildError if `to` already has a connection, or a port belongs to
  /// another diagram.
  template <class From, class To>
  void Connect(const From& from, To& to) {
    static_assert(std::is_same_v<typename From::Value, typename To::Value>,
                  "Connect: the two ports have different types.");
    Join(from, to);
  }
  /// Connects ports whose units differ on purpose, which Build would otherwise report.
  template <class From, class To>
  void Connect(const From& from, To& to, IgnoreUnits) {
    Connect(from, to);
    IgnoreUnitsOf(to);
  }

  /// Adds a block that computes one function of the values in `uses`, connects it to them, and returns its
  /// output. `Uses(builder.time, plant.state)` may name outputs of other blocks and the diagram's own inputs.
  template <class... A, class F>
  auto& AddFunction(Spec spec, UsesList<A...> uses, F function) {
    return MakeFunctionBlock(std::move(spec), uses, std::move(function)).output;
  }
  /// Adds a function with a model of its value, which declares the size of a vector that is known only at run
  /// time: `AddFunction("f", Eigen::VectorXd::Zero(6), Uses(plant.state), ForceOf)`.
  template <class... A, class F>
  auto& AddFunction(Spec spec, std::type_identity_t<ResultOf<F, A...>> model, UsesList<A...> uses,
                    F function) {
    return MakeFunctionBlock(std::move(spec), uses, std::move(function), std::move(model)).output;
  }
  /// Adds a function that jumps or bends at known instants, see NextJump: integrator steps end exactly there.
  ///
  ///     builder.AddFunction({"force", "N"}, JumpsAt{{5, 6}}, Uses(builder.time),
  ///                         [](double t) { return t >= 5 && t < 6 ? 1.0 : 0.0; });
  template <class... A, class F>
  auto& AddFunction(Spec spec, JumpsAt jumps, UsesList<A...> uses, F function) {
    auto& block = MakeFunctionBlock(std::move(spec), uses, std::move(function));
    block.next_jump.emplace(&block, "next_jump", Uses(block.time),
                            [jumps = std::move(jumps)](double time_now) { return jumps.Next(time_now); });
    return block.output;
  }
  /// Adds a function that is sampled.
  template <class... A, class F>
  auto& AddFunction(Spec spec, Sampled sampled, UsesList<A...> uses, F function) {
    return MakeFunctionBlock(std::move(spec), uses, std::move(function), sampled).output;
  }
  /// Adds a function that is sampled, with its value before the first tick; see OutputPort.
  template <class... A, class F>
  auto& AddFunction(Spec spec, std::type_identity_t<ResultOf<F, A...>> initial, Sampled sampled,
                    UsesList<A...> uses, F function) {
    return MakeFunctionBlock(std::move(spec), uses, std::move(function), std::move(initial), sampled).output;
  }

  /// A call without Uses(...), which reports that it is missing.
  template <class... Args>
  requires internal::kLacksUses<Args...>
  const OutputPort<double>& AddFunction(Spec, const Args&...) {
    internal::ReportMissingUses<UsesList<Args...>>();
    throw BuildError("");
  }

  const std::vector<std::unique_ptr<System>>& blocks() const { return blocks_; }

  const Time time{};

 protected:
  explicit Assembly(System* self) : self_(self) {}
  ~Assembly() = default;
  std::vector<std::unique_ptr<System>> TakeBlocks() { return std::move(blocks_); }
  std::vector<std::unique_ptr<System>> TakeReplaced() { return std::move(replaced_); }
  void CheckNotBuilt(const char* call, const std::string& subject) const;
  /// After this call, changing this assembly or a diagram nested in it throws BuildError, and members of
  /// replaced blocks have the values of those in their places. If `replaced`, all blocks are replaced ones.
  void MarkBuilt(bool replaced = false);

 private:
  friend class Compiler;

  template <class... A, class F, class... When>
  auto& MakeFunctionBlock(Spec spec, const UsesList<A...>& uses, F function, When... when);
  /// True if the argument is the block's parameters.
  template <class Block, class... Args>
  static constexpr bool LacksConstructors() {
    if constexpr (requires { typename ParamsOf<Block>; } && sizeof...(Args) == 1) {
      return (std::is_same_v<std::remove_cvref_t<Args>, ParamsOf<Block>> && ...);
    } else {
      return false;
    }
  }
  /// Returns a System: a unique_ptr<Block> would cost every block of a program its compile time.
  template <class Block, class... Args>
  static std::unique_ptr<System> Make(const std::string& name, Args&&... args) {
    if constexpr (!std::is_base_of_v<System, Block>) {
      static_assert(kFalse<Block>, "Add: a block must derive from LeafSystem or Subdiagram.");
      throw BuildError("");
    } else if constexpr (!std::is_constructible_v<Block, Args&&...> && LacksConstructors<Block, Args...>()) {
      static_assert(
          kFalse<Block>,
          "Add: the block does not take its parameters: write `using LeafSystem::LeafSystem;` in it.");
      throw BuildError("");
    } else if constexpr (!std::is_constructible_v<Block, Args&&...>) {
      static_assert(kFalse<Block>, "Add: the block's constructor does not take these arguments.");
      throw BuildError("");
    } else {
      try {
        return std::unique_ptr<System>(new Block(std::forward<Args>(args)...));
      } catch (...) {
        RethrowWithName(name);
      }
    }
  }
  void CheckName(const std::string& name) const;
  bool IsBelow(const System& block) const;
  void CheckBelow(const System& block) const;
  Source& Standing(const Source& port) const;
  System& Exchange(const System& old, std::unique_ptr<System> block);
  void Splice(const Source& output, Source& in, const Source& out, const std::vector<const Source*>& except);
  void SpliceBefore(Source& input, Source& in, const Source& out);
  /// The sources of all blocks of the diagram, as far as this assembly knows it.
  std::vector<Source*> AllSources();
  void AppendSources(std::vector<Source*>& sources);
  System& Adopt(std::unique_ptr<System> block, const std::string& name);
  void Join(const Source& from, Source& to);
  static void IgnoreUnitsOf(Source& to);
  [[noreturn]] static void RethrowWithName(const std::string& name);

  System* self_;  ///< the subdiagram, or null at top level
  bool built_ = false;
  std::vector<std::unique_ptr<System>> blocks_;
  std::unordered_map<std::string, const System*> by_name_;  ///< blocks
  std::vector<std::unique_ptr<System>> replaced_;
};

/// The inputs of a function block, one for each port that it uses; `time` needs no input.
template <class... A>
class FunctionInputs {
 public:
  FunctionInputs([[maybe_unused]] Leaf* owner, [[maybe_unused]] const std::vector<Slot>& used) {
    (Append<A>(owner, used[uses.slots.size()]), ...);
  }
  UsesList<A...> uses;          ///< the list for the calculation
  std::vector<Source*> inputs;  ///< null for time

 private:
  template <class Argument>
  void Append(Leaf* owner, const Slot& used) {
    if (used.source == nullptr) {
      inputs.push_back(nullptr);
      return owner->time.AppendTo(uses.slots);
    }
    using Input = InputPort<std::remove_cvref_t<Argument>>;
    const Spec& spec = used.source->Current().spec();
    const auto input = std::make_shared<Input>(
        owner, Spec("input_" + std::to_string(inputs.size()), spec.units, spec.elements));
    inputs.push_back(input.get());
    input->AppendTo(uses.slots);
    kept_.push_back(input);
  }
  std::vector<std::shared_ptr<void>> kept_;
};

/// The block that AddFunction adds.
template <class R, class F, class... A>
class FunctionBlock final : public Leaf {
 public:
  template <class... When>
  FunctionBlock(Spec spec, const UsesList<A...>& used, F function, When... when)
      : in(this, used.slots),
        output(this, Spec("output", spec.units, spec.elements), std::move(when)..., in.uses,
               std::move(function)) {}

  FunctionInputs<A...> in;
  OutputPort<R> output;
  std::optional<NextJump> next_jump = {};
};

template <class... A, class F, class... When>
auto& Assembly::MakeFunctionBlock(Spec spec, const UsesList<A...>& uses, F function, When... when) {
  using R = ResultOf<F, A...>;
  CheckNotBuilt("AddFunction", spec.name);
  if (uses.undeclared > 0) ThrowUndeclared("the function '" + spec.name + "'", "a member");
  auto& block =
      Add<FunctionBlock<R, F, A...>>(spec.name, spec, uses, std::move(function), std::move(when)...);
  for (std::size_t i = 0; i < uses.slots.size(); ++i) {
    if (block.in.inputs[i] != nullptr) Join(*uses.slots[i].source, *block.in.inputs[i]);
  }
  return block;
}

}  // namespace internal

/// Collects blocks and connections and compiles them into a Diagram.
class DiagramBuilder : public internal::Assembly {
 public:
  DiagramBuilder() : Assembly(nullptr) {}
  /// Checks and compiles the diagram, which then owns the blocks. Afterwards the builder is empty and cannot
  /// be used again: Add, Connect, Build and all other changes, also of nested diagrams, throw BuildError.
  ///
  /// Throws BuildError that lists all faults found: unconnected inputs, different units or sizes, algebraic
  /// loops (with every hop), states without derivative, offsets without initial value. In that case the
  /// builder is unchanged, and can be corrected and built again.
  std::shared_ptr<const Diagram> Build();
  /// Builds a diagram in which inputs may be unconnected; set their values in each context.
  std::shared_ptr<const Diagram> BuildWithOpenInputs();

 private:
  std::shared_ptr<const Diagram> Compile(const char* call, bool open_inputs);
};

/// A block made of blocks. Derive from it, declare its ports as members, and add and connect blocks in the
/// constructor. Its ports are connected from both sides.
class Subdiagram : public System, public internal::Assembly {
 public:
  Subdiagram() : Assembly(this) {}
};

/// Returns the block that now stands where `block` stood in its diagram: itself, the block that replaced it,
/// or, if a diagram around it was replaced, the block with its path in the new one. Null if there is none.
const System* CurrentBlock(const System& block);

/// Returns the block that stands in the place of `block` as a B, for its parameters and other members. B is
/// the class of `block`, or `LeafSystem<P>` for any block with parameters of type P. If the block in its
/// place is of another class, that is the last block there that was a B.
template <class B>
const B& CurrentAs(const B& block) {
  const B* last = &block;
  const auto take = [&](const System* each) {
    if (const auto* same = dynamic_cast<const B*>(each)) last = same;
  };
  for (const System* each = block.replaced_by(); each != nullptr; each = each->replaced_by()) take(each);
  take(CurrentBlock(block));
  return *last;
}

template <class T>
OutputPort<T>::OutputPort(Subdiagram* owner, Spec spec)
    : Calculated<T>(owner, SourceKind::kOutput, std::move(spec)) {}

}  // namespace tenon
