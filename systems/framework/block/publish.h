#pragma once

#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>

#include <string>
#include <utility>

namespace tenon {

/// A side effect: something is sent, written or shown. Its function returns nothing and receives what Uses
/// names, like any other:
///
///     Publish send{this, "send", Sampled{params.rate}, Uses(time, state), &Radio::Send};
///
/// It runs at a rate, after every step of the integrator, once at the start, or when a witness fires, and
/// never inside an evaluation. At a tick it runs when what it uses is known, and before the ExternalInputs
/// that it does not depend on: so these may wait for the answer. Like updates, it reads the values before the
/// updates of that instant take effect; with AtStart, what the run begins with, after the tick at the start.
///
/// Nothing that it does reaches the run, and its ticks restart no integrator. The block is shared by all
/// contexts of a diagram: what the function changes (a socket, a file) must bear that, or SimulatorOptions
/// says `.publish = false`. What it throws ends the run, with its path.
class Publish : public Calculated<internal::Published> {
 public:
  template <class... A, class F>
  Publish(Leaf* owner, std::string name, Trigger trigger, UsesList<A...> uses, F function,
          std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<internal::Published>(owner, SourceKind::kPublish, Spec{std::move(name)}) {
    SetTrigger(trigger);
    Calculate(std::move(uses), std::move(function), tag);
  }
};

}  // namespace tenon
