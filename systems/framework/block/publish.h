#pragma once

#include <tenon/systems/framework/block/state.h>

namespace tenon {

/// A side effect: sends, writes or shows something. Its function returns nothing and receives the values
/// named in Uses:
///
///     Publish send{this, "send", Sampled{params.rate}, Uses(time, state), &Radio::Send};
///
/// It runs at a rate, after every integrator step, once at the start, or when a witness fires, and never
/// inside an evaluation. At a tick it runs as soon as the values it uses are known, and before every
/// ExternalInput that it does not depend on, so that an ExternalInput may wait for the answer. Like updates,
/// it reads the values before the updates of that instant take effect. With AtStart it runs after the tick at
/// the start and reads the initial values.
///
/// A Publish cannot affect the run, and its ticks do not restart the integrator. All contexts of a diagram
/// share the block, so anything that the function changes (a socket, a file) must allow for that; otherwise
/// set SimulatorOptions::publish to false. An exception ends the run with a RunError that names the Publish.
class Publish : public Calculated<internal::Published> {
 public:
  using Calculated<internal::Published>::Calculated;
  template <class... A, class F>
  Publish(Leaf* owner, std::string name, Trigger trigger, UsesList<A...> uses, F function,
          std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<internal::Published>(owner, SourceKind::kPublish, Spec{std::move(name)}) {
    SetTrigger(trigger);
    Calculate(std::move(uses), std::move(function), tag);
  }
};

}  // namespace tenon
