#pragma once

#include <tenon/systems/simulation/simulator.h>

namespace tenon {

/// Runs one block whose inputs the test sets:
///
///     TestRig<Pd> rig(PdParams{.kp = 3});
///     rig.Fix(rig.system().x, {1, 0}).Fix(rig.system().ref, 2).Tick();
///     EXPECT_EQ(rig[rig.system().u], 3);
///
/// Makes a diagram of the block, named "block", with open inputs, and integrates it to tight tolerances.
template <class Block>
class TestRig {
 public:
  /// The block with parameters in braces: `TestRig<Pd> rig({.kp = 3})`.
  explicit TestRig(internal::ParamsOf<Block> params) {
    DiagramBuilder builder;
    block_ = &builder.Add<Block>("block", std::move(params));
    Build(builder);
  }
  /// The arguments are those of the block's constructor. Throws what the block throws.
  template <class... Args>
  explicit TestRig(Args&&... args) {
    DiagramBuilder builder;
    block_ = &builder.Add<Block>("block", std::forward<Args>(args)...);
    Build(builder);
  }

  /// The block; writable, so that members can be named in `Fix`.
  Block& system() { return *block_; }
  /// Access to members of the block: `rig[rig->u]`.
  Block* operator->() { return block_; }

  /// Fixes the value of an input.
  template <class T>
  TestRig& Fix(const InputPort<T>& input, const std::type_identity_t<T>& value) {
    context().Set(input, value);
    return *this;
  }
  /// Sets a state, continuous or discrete, or a scratch value.
  template <class S>
  TestRig& Set(const S& state, const typename S::Value& value) {
    context().Set(state, value);
    return *this;
  }

  /// The first call runs the tick at t = 0; every other call advances to the next tick of the block and runs
  /// it: sampled outputs, then updates. Throws RunError if the block has no sample times.
  TestRig& Tick() {
    if (!started_) return RunTo(context().time());
    const double next = simulator_->next_tick_time();
    if (std::isinf(next)) {
      throw RunError("the block has no tick after t = " + std::to_string(context().time()) +
                     " s: nothing in it is sampled; use RunTo");
    }
    return RunTo(next);
  }
  /// Runs up to and including the tick at `time` [s], or to the time at which a monitor of the block ends the
  /// run; the verdict can be read like any other value.
  TestRig& RunTo(double time) {
    static_cast<void>(simulator_->AdvanceTo(time));
    started_ = true;
    return *this;
  }
  /// Runs the block from its present values to `time` [s] in two copies of the context. Throws RunError that
  /// names an output or state that differs. Then a calculation remembers something outside of the context,
  /// in a `mutable` member or a static variable, say, and runs cannot be repeated. The rig itself stays at
  /// its time.
  TestRig& CheckRepeats(double time) {
    const auto first = ValuesAt(time), second = ValuesAt(time);
    for (std::size_t i = 0; i < first.size(); ++i) {
      const auto& [source, values] = first[i];
      if (std::equal(values.begin(), values.end(), second[i].second.begin(), second[i].second.end(),
                     [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); })) {
        continue;
      }
      throw RunError("'" + source->path() + "' differs at t = " + std::to_string(time) +
                     " s when the run is repeated: keep what its calculations remember in a DiscreteState or "
                     "a Scratch, not in a `mutable` member or a static variable");
    }
    return *this;
  }
  double time() const { return simulator_->context().time(); }

  /// The value of a port, state, derivative, shared value or witness.
  template <class S>
  const typename S::Value& operator[](const S& source) {
    return context().Eval(source);
  }
  /// The time derivative of a state, at the present values.
  template <class T>
  const T& Derivative(const ContinuousState<T>& state) {
    for (const Source* source : state.owner().sources()) {
      if (source->kind() == SourceKind::kDerivative && source->name() == "d/dt " + state.name()) {
        return context().Eval(static_cast<const TimeDerivative<T>&>(*source));
      }
    }
    throw Error("'" + state.path() + "' has no time derivative");
  }

  Context& context() { return simulator_->context(); }
  const Diagram& diagram() const { return *diagram_; }
  Simulator& simulator() { return *simulator_; }

 private:
  void Build(DiagramBuilder& builder) {
    diagram_ = builder.BuildWithOpenInputs();
    simulator_ =
        std::make_unique<Simulator>(*diagram_, SimulatorOptions{.order = 5, .rtol = 1e-10, .atol = 1e-12});
  }
  std::vector<std::pair<const Source*, std::vector<double>>> ValuesAt(double time) {
    Simulator copy(context().Clone(),
                   SimulatorOptions{.order = 5, .rtol = 1e-10, .atol = 1e-12, .publish = false});
    static_cast<void>(copy.AdvanceTo(time));
    std::vector<std::pair<const Source*, std::vector<double>>> values;
    for (const Source* source : block_->sources()) {
      const SourceKind kind = source->kind();
      if (kind == SourceKind::kOutput || kind == SourceKind::kContinuous || kind == SourceKind::kDiscrete) {
        values.emplace_back(source, copy.context().EvalDoubles(*source));
      }
    }
    return values;
  }

  Block* block_;
  std::shared_ptr<const Diagram> diagram_;
  std::unique_ptr<Simulator> simulator_;
  bool started_ = false;
};

}  // namespace tenon
