#pragma once

#include <tenon/systems/framework/context/context.h>

namespace tenon::internal {

/// Returns the path of every number of the sources in order, such as "cart.x.velocity".
std::vector<std::string> NumberNames(const Context& context, const std::vector<const Source*>& sources);

/// Returns the concatenated numbers of the sources from EvalDoubles.
Eigen::VectorXd EvalNumbers(Context& context, const std::vector<const Source*>& sources);

/// The real numbers of settable sources as one vector, for central differences. Bools, integers, enumerations
/// and values that are not numbers keep their values in the context.
class RealNumbers {
 public:
  RealNumbers(const Context& context, std::vector<const Source*> sources);

  Eigen::Index size() const { return static_cast<Eigen::Index>(names_.size()); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }
  /// Throws RunError that names the source if its size has changed.
  Eigen::VectorXd Get(Context& context) const;
  /// Throws RunError as SetDoubles does.
  void Set(Context& context, const Eigen::VectorXd& values) const;

 private:
  struct Part {
    const Source* source;
    std::vector<bool> is_real;  ///< whether each of its numbers is real
  };
  std::vector<double> Eval(Context& context, const Part& part) const;

  std::vector<Part> parts_;
  std::vector<std::string> names_;
  std::vector<std::string> units_;
};

}  // namespace tenon::internal
