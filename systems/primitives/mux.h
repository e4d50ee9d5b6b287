#pragma once

#include <tenon/systems/framework/block/state.h>

#include <deque>
#include <string>

namespace tenon {

struct MuxParams {
  std::string units = "";     ///< units of the vector's elements, comma-separated: one for all, or one each
  std::string elements = "";  ///< names of the elements, comma-separated; indices if empty
};

/// Combines N numbers into a vector:
///
///     y = (u_0, …, u_(N-1))
///
///     | port            | kind   | size        | unit  |
///     | u[0] … u[N - 1] | input  | double each |       |
///     | y               | output | Vec<N>      | units |
template <int N>
class Mux final : public LeafSystem<MuxParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPorts<double> u{this, "u", N};
  OutputPort<Vec<N>> y{
      this, {"y", params.units, params.elements}, Uses(u), [](const Inputs<double>& u) -> Vec<N> {
        Vec<N> y;
        for (int i = 0; i < N; ++i) y[i] = u[i];
        return y;
      }};
};

/// Splits a vector into its elements:
///
///     y_i = u_i
///
///     | port            | kind   | size        | unit              |
///     | u               | input  | Vec<N>      | units             |
///     | y[0] … y[N - 1] | output | double each | the one of u[i]   |
template <int N>
class Demux final : public LeafSystem<MuxParams> {
 public:
  explicit Demux(MuxParams p = {}) : LeafSystem(std::move(p)) {
    for (int i = 0; i < N; ++i) {
      y.emplace_back(this, Spec("y_" + std::to_string(i), internal::ElementUnit(u.spec(), i)), Uses(u),
                     [i](const Vec<N>& u) -> double { return u[i]; });
    }
  }
  InputPort<Vec<N>> u{this, {"u", params.units, params.elements}};
  std::deque<OutputPort<double>> y;
};

}  // namespace tenon
