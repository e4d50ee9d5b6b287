#pragma once

#include <tenon/systems/framework/block/state.h>

#include <deque>
#include <tuple>

namespace tenon {

struct ConcatenateParams {
  /// One entry per port: its name, and the units and element names of a port that is not a struct. If empty,
  /// the ports are named u_0, u_1, …, in a Split y_0, y_1, ….
  std::vector<Spec> ports = {};
};

namespace internal {

/// Spec of the i-th of several ports. Throws ParameterError for a port whose size is known only at run time.
template <class T>
Spec PortOf(const std::vector<Spec>& ports, std::size_t count, const std::string& name, std::size_t i) {
  Demand(ports.empty() || ports.size() == count, "ports has " + std::to_string(ports.size()) +
                                                     " entries, but there are " + std::to_string(count) +
                                                     " signals: give one entry per signal, or none");
  const Spec spec = ports.empty() ? Spec(name + "_" + std::to_string(i)) : ports[i];
  Demand(TypeInfoOf<T>().fixed,
         "'" + spec.name + "' has a size that is known only at run time: use signals of fixed size");
  return spec;
}

/// Total count of numbers in values of these types.
template <class... Ts>
Eigen::Index TotalSize() {
  return static_cast<Eigen::Index>((std::size_t{0} + ... + TypeInfoOf<Ts>().num_scalars));
}

/// Spec of a vector of the numbers of several ports, with elements such as "force.x, force.y, mass".
inline Spec Joined(const std::string& name, const std::vector<const Source*>& ports) {
  Spec joined(name);
  for (const Source* port : ports) {
    for (const Element& element : port->elements()) {
      if (!joined.elements.empty()) joined.elements += ", ", joined.units += ", ";
      joined.elements += element.PathIn(port->name());
      joined.units += element.unit;
    }
  }
  if (joined.units.find_first_not_of(", ") == std::string::npos) joined.units.clear();
  return joined;
}

}  // namespace internal

/// Makes one vector of all numbers of several signals, which may have different types:
///
///     y = (u_0, u_1, …)
///
///     Concatenate<double, Vec<3>, TrunkState>({.ports = {{"height", "m"}, {"force", "N"}, "trunk"}})
///
/// Elements of y are named by their port and element: "force.x". Ts are numbers, enumerations, matrices of
/// fixed size and structs of these with Fields(). To make a struct of several signals, use
/// DiagramBuilder::AddFunction. Throws ParameterError if the number of names is wrong or a type has no fixed
/// size.
template <class... Ts>
class Concatenate final : public LeafSystem<ConcatenateParams> {
  using Ports = std::tuple<std::unique_ptr<InputPort<Ts>>...>;
  template <std::size_t... I>
  Ports MakePorts(std::index_sequence<I...>) {
    return {
        std::make_unique<InputPort<Ts>>(this, internal::PortOf<Ts>(params.ports, sizeof...(Ts), "u", I))...};
  }

 public:
  using LeafSystem::LeafSystem;
  template <std::size_t I>
  auto& u() {
    return *std::get<I>(ports_);
  }

 private:
  const Ports ports_ = MakePorts(std::index_sequence_for<Ts...>());
  const Spec joined_ =
      std::apply([](const auto&... port) { return internal::Joined("y", {port.get()...}); }, ports_);

 public:
  OutputPort<Eigen::VectorXd> y{this, joined_, Eigen::VectorXd::Zero(internal::TotalSize<Ts...>()),
                                std::apply([](const auto&... port) { return Uses(*port...); }, ports_),
                                [](const Ts&... values, Eigen::VectorXd* y_out) {
                                  double* out = y_out->data();
                                  ((out = internal::ToDoubles(internal::TypeInfoOf<Ts>(), &values, out)),
                                   ...);
                                }};
};

/// Splits a vector into signals of any types, as Concatenate joins them:
///
///     (y_0, y_1, …) = u
///
/// Throws ParameterError if the number of names is wrong or a type has no fixed size. During a run throws
/// RunError if the size of u differs from the total size of the parts, and ParameterError if a part cannot
/// hold a number (a fraction for an integer, say).
template <class... Ts>
class Split final : public LeafSystem<ConcatenateParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<Eigen::VectorXd> u{this, "u"};
  template <std::size_t I>
  auto& y() {
    return *std::get<I>(ports_);
  }

 private:
  template <class T>
  std::unique_ptr<OutputPort<T>> MakePort(std::size_t i, Eigen::Index& begin) {
    const auto take = [begin](const Eigen::VectorXd& u_now, T* part) {
      if (u_now.size() != internal::TotalSize<Ts...>()) {
        throw RunError("u has " + std::to_string(u_now.size()) + " elements, but the parts have a total of " +
                       std::to_string(internal::TotalSize<Ts...>()) + ": make them equal");
      }
      internal::FromDoubles(internal::TypeInfoOf<T>(), part, u_now.data() + begin);
    };
    begin += internal::TotalSize<T>();
    return std::make_unique<OutputPort<T>>(this, internal::PortOf<T>(params.ports, sizeof...(Ts), "y", i),
                                           Uses(u), take);
  }
  using Ports = std::tuple<std::unique_ptr<OutputPort<Ts>>...>;
  template <std::size_t... I>
  Ports MakePorts(std::index_sequence<I...>) {
    Eigen::Index begin = 0;
    return {MakePort<Ts>(I, begin)...};
  }
  const Ports ports_ = MakePorts(std::index_sequence_for<Ts...>());
};

struct MuxParams {
  std::string units = "";     ///< units of the vector's elements, comma-separated: one for all, or one each
  std::string elements = "";  ///< names of the elements, comma-separated; indices if empty
};

/// Combines N numbers into a vector:
///
///     y = (u_0, …, u_(N-1))
template <int N>
class Mux final : public LeafSystem<MuxParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPorts<double> u{this, "u", N};
  OutputPort<Vec<N>> y{
      this, {"y", params.units, params.elements}, Uses(u), [](const Inputs<double>& u_now) -> Vec<N> {
        Vec<N> all;
        for (int i = 0; i < N; ++i) all[i] = u_now[i];
        return all;
      }};
};

/// Splits a vector into its elements:
///
///     y_i = u_i
template <int N>
class Demux final : public LeafSystem<MuxParams> {
 public:
  explicit Demux(MuxParams p = {}) : LeafSystem(std::move(p)) {
    for (int i = 0; i < N; ++i) {
      y.emplace_back(this, Spec("y_" + std::to_string(i), internal::ElementUnit(u.spec(), i)), Uses(u),
                     [i](const Vec<N>& u_now) -> double { return u_now[i]; });
    }
  }
  InputPort<Vec<N>> u{this, {"u", params.units, params.elements}};
  std::deque<OutputPort<double>> y;
};

}  // namespace tenon
