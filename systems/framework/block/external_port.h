#pragma once

#include <tenon/systems/framework/block/state.h>

namespace tenon {

/// A sampled output that takes its value from outside the diagram: from another thread, a socket, a file.
///
/// At a tick it runs after all Publishes that do not depend on it, so its function may wait for the answer to
/// what they sent. Keep the received value in the context (in a Scratch, say), so that saved contexts contain
/// it. Use it in your own block for a new source; ExternalInput is for threads, and network/udp.h for UDP.
template <class T>
class ExternalPort : public OutputPort<T> {
 public:
  template <class... A, class F>
  ExternalPort(Leaf* owner, Spec spec, T initial, Sampled sampled, UsesList<A...> uses, F function,
               std::uint64_t tag = internal::TagOf<F>::value)
      : OutputPort<T>(owner, std::move(spec), std::move(initial), sampled, std::move(uses),
                      std::move(function), tag) {
    this->SetComesFromOutside();
  }
};

}  // namespace tenon
