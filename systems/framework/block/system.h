#pragma once

#include <tenon/systems/framework/block/calculation.h>

namespace tenon {

namespace internal {

class ParameterSource;

/// Values of some of one block's Parameters.
class ParameterValues {
 public:
  struct Value {
    const TypeInfo* type;
    std::size_t offset;  ///< in the block's `params` [bytes]
    const void* value;
  };
  void Add(Value value) { values_.push_back(value); }
  /// Writes the values into a copy of the block's `params`.
  void WriteInto(std::byte* params) const {
    for (const Value& each : values_) each.type->assign(params + each.offset, each.value);
  }

 private:
  std::vector<Value> values_;
};

}  // namespace internal

/// A block: a LeafSystem that computes, or a Subdiagram that contains further blocks. It has a name, unique
/// among its siblings, and ports that are members of the derived class.
class System {
 public:
  System() = default;
  System(const System&) = delete;
  System& operator=(const System&) = delete;
  virtual ~System() = default;

  const std::string& name() const { return name_; }
  /// Names from the outermost subdiagram down, joined by dots; just the name at top level.
  std::string path() const;
  const System* parent() const { return parent_; }
  /// The block that replaced this one in the diagram (see DiagramBuilder::Replace); null if it was not
  /// replaced.
  const System* replaced_by() const { return replaced_by_; }
  /// The ports, states and other members, in the order of their declaration.
  const std::vector<Source*>& sources() const { return sources_; }

 private:
  friend class Source;
  friend class internal::Assembly;
  friend class internal::Compiler;

  std::string name_;
  const System* parent_ = nullptr;
  internal::Assembly* holder_ = nullptr;  ///< the builder or Subdiagram that it was added to
  const System* replaced_by_ = nullptr;
  const System* replaces_ = nullptr;
  std::vector<Source*> sources_;
};

/// A block that computes. Derive from LeafSystem instead.
class Leaf : public System {
 public:
  const Time time{};

 private:
  friend class Context;
  friend class internal::ParameterSource;
  /// Throws ParameterError if the block's `params` are invalid with these values of its Parameters.
  virtual void ValidateParameters(const internal::ParameterValues&) const {}
  /// The memory of the block's `params`.
  virtual std::span<const std::byte> ParameterBytes() const { return {}; }
  /// The members of `params`; null if these do not describe themselves.
  virtual const FieldList* ParameterFields() const { return nullptr; }
};

/// The base of every block that computes. Ports, states and calculations are members that register
/// themselves:
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
/// `params` is a member of the base, so that the block's members can use it. If it has `Fields()`, the
/// constructor checks the ranges in that list first; then, if it has a `void Validate() const`, it calls that
/// for what concerns several members. Both throw ParameterError, to which the builder adds the block's name.
/// Declare values that change during a run as Parameters.
template <class P>
class LeafSystem : public Leaf {
 public:
  using Params = P;
  explicit LeafSystem(P p = P()) : params(std::move(p)) {
    if constexpr (HasFields<P>) CheckRanges(params);
    if constexpr (requires { params.Validate(); }) params.Validate();
  }
  const P params;

 private:
  void ValidateParameters([[maybe_unused]] const internal::ParameterValues& values) const override {
    if constexpr (requires { params.Validate(); }) {
      P changed = params;
      values.WriteInto(reinterpret_cast<std::byte*>(&changed));
      changed.Validate();
    }
  }
  std::span<const std::byte> ParameterBytes() const override {
    return {reinterpret_cast<const std::byte*>(&params), sizeof(P)};
  }
  const FieldList* ParameterFields() const override {
    if constexpr (HasFields<P>) {
      return &internal::FieldsOf<P>();
    } else {
      return nullptr;
    }
  }
};

/// A block without parameters.
template <>
class LeafSystem<void> : public Leaf {};

/// Throws ParameterError(text) unless `condition` holds.
inline void Demand(bool condition, const std::string& text) {
  if (!condition) throw ParameterError(text);
}

}  // namespace tenon
