#pragma once

#include <tenon/systems/framework/block/source.h>
#include <tenon/systems/framework/block/system.h>

#include <cstddef>
#include <string>
#include <utility>

namespace tenon {

namespace internal {

/// What Parameters of all types share.
class ParameterSource : public Source {
 public:
  /// What it means, in words.
  const std::string& description() const { return description_; }

 protected:
  /// `given` is the value as the block wrote it down.
  ParameterSource(Leaf* owner, Spec spec, const TypeInfo& type, const void* model, const void* given,
                  std::string description);
  ~ParameterSource() = default;

 private:
  friend class tenon::Context;
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::size_t offset_in_params_ = kNone;  ///< [bytes]
  std::string description_;
};

}  // namespace internal

/// A value of the context that nothing changes but Context::Set: a gain, a limit, a mass. A calculation uses
/// it like a state:
///
///     Parameter<double> kp{this, {"kp", "N/m"}, params.kp, "stiffness"};
///     OutputPort<double> u{this, {"u", "N"}, Uses(kp, x), [](double kp, double x) { return -kp * x; }};
///
/// and a run changes it between advances: `context.Set(pd.kp, 12)`. What `params` holds is where it starts.
/// If `initial` is a member of `params` (or of a member), then setting it runs `params.Validate()` with the
/// present values of all Parameters of the block. Contexts save and clone it, Diagram::parameters() lists it.
/// `T` is any copyable type; a struct with Fields() is set as a whole.
template <class T>
class Parameter : public internal::ParameterSource {
 public:
  using Value = T;
  using Argument = const T&;

  Parameter(Leaf* owner, Spec spec, const T& initial, std::string description = "")
      : ParameterSource(owner, std::move(spec), internal::TypeInfoOf<T>(), &initial_, &initial,
                        std::move(description)),
        initial_(initial) {}

 private:
  T initial_;
};

}  // namespace tenon
