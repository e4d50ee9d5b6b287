#pragma once

#include <tenon/systems/framework/block/system.h>

namespace tenon {

namespace internal {

/// The part of a Parameter that does not depend on its type.
class ParameterSource : public Source {
 public:
  /// The meaning of the parameter, in words.
  const std::string& description() const { return description_; }
  /// The range of the numbers; those of a struct have the ranges of its fields.
  const Range& range() const { return range_; }
  /// The range of each number, in the order of initial_numbers().
  std::vector<Range> ranges() const;
  /// The place of the initial value in the block's `params` [bytes]; kNone if it is not a member of them.
  std::size_t offset_in_params() const { return offset_in_params_; }
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

 protected:
  /// `given` is the address of the initial value in the block's source, possibly inside its `params`.
  ParameterSource(Leaf* owner, Spec spec, const TypeInfo& type, const void* model, const void* given,
                  std::string description, const Range& range);
  ~ParameterSource() = default;

 private:
  friend class tenon::Context;
  /// Throws ParameterError if a value is out of range or invalid.
  void Check(const void* value) const;

  std::size_t offset_in_params_ = kNone;
  std::string description_;
  Range range_;  ///< of each number; a struct has its own
};

}  // namespace internal

/// A value of the context that only Context::Set changes: a gain, a limit, a mass. A calculation uses it like
/// a state:
///
///     Parameter<double> kp{this, {"kp", "N/m"}, params.kp, "stiffness"};
///     OutputPort<double> u{this, {"u", "N"}, Uses(kp, x), [](double kp, double x) { return -kp * x; }};
///
/// and it can be changed between advances of a run: `context.Set(pd.kp, 12)`. The initial value is the one in
/// `params`. If `initial` is a member of `params` (or of a member), setting the Parameter calls
/// `params.Validate()` with the present values of all Parameters of the block. Contexts save and clone it,
/// and Diagram::parameters() lists it. `T` is any copyable type; a struct with Fields() is set as a whole.
///
/// A value outside of the range throws ParameterError, in the constructor and when it is set. A struct has
/// the ranges of its fields, and its Validate() is called; another value has the range of the field of
/// `params` that it starts from, or `range`:
///
///     Parameter<double> kp{this, {"kp", "N/m"}, params.kp, "stiffness", Range().Positive()};
template <class T>
class Parameter : public internal::ParameterSource {
 public:
  using Value = T;
  using Argument = const T&;

  Parameter(Leaf* owner, Spec spec, const T& initial, std::string description = "", const Range& range = {})
      : ParameterSource(owner, std::move(spec), internal::TypeInfoOf<T>(), &initial_, &initial,
                        std::move(description), range),
        initial_(initial) {}

 private:
  T initial_;
};

}  // namespace tenon
