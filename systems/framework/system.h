#pragma once

#include <string>
#include <vector>

#include <tenon/systems/framework/calculation.h>
#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/source.h>

namespace tenon {

/// A block: a LeafSystem that computes, or a Subdiagram that holds further blocks. Has a name, unique among
/// its siblings, and ports that are members of the derived class.
class System {
 public:
  System() = default;
  System(const System&) = delete;
  System& operator=(const System&) = delete;
  virtual ~System() = default;

  const std::string& name() const { return name_; }
  /// Names from the outermost subdiagram down, joined by dots; the name alone at top level.
  std::string path() const;
  const System* parent() const { return parent_; }
  /// The ports, states and other members, in the order of their declaration.
  const std::vector<Source*>& sources() const { return sources_; }

 private:
  friend class Source;
  friend class internal::Assembly;
  friend class internal::Compiler;

  std::string name_;
  const System* parent_ = nullptr;
  std::vector<Source*> sources_;
};

/// A block that computes. Use LeafSystem.
class Leaf : public System {
 public:
  const Time time{};
};

/// The base of every block of one's own. Ports, states and calculations are members that register themselves:
///
///     struct PdParams {
///       double kp = 10;         // N/m
///       double kd = 2;          // N s/m
///       Rate rate = Hz(1000);
///     };
///     class Pd final : public LeafSystem<PdParams> {
///      public:
///       using LeafSystem::LeafSystem;
///       InputPort<Vec<2>>  x{this, {"x", "m, m/s"}};
///       InputPort<double>  ref{this, {"ref", "m"}};
///       OutputPort<double> u{this, {"u", "N"}, Sampled{params.rate}, Uses(x, ref), &Pd::CalcU};
///      private:
///       double CalcU(const Vec<2>& x, double ref) const {
///         return params.kp * (ref - x[0]) - params.kd * x[1];
///       }
///     };
///
/// Parameters stand in the base, so that the members can use them. If they have a `void Validate() const`, it
/// runs first and throws ParameterError; the builder adds the block's name.
template <class Params>
class LeafSystem : public Leaf {
 public:
  explicit LeafSystem(Params p = Params()) : params(std::move(p)) {
    if constexpr (requires { params.Validate(); }) params.Validate();
  }
  const Params params;
};

/// A block without parameters.
template <>
class LeafSystem<void> : public Leaf {};

/// Throws ParameterError(text) unless `condition` holds.
inline void Demand(bool condition, const std::string& text) {
  if (!condition) throw ParameterError(text);
}

}  // namespace tenon
