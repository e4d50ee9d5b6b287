#pragma once

#include <tenon/systems/framework/context/context.h>

#include <Eigen/Core>

#include <string>
#include <vector>

namespace tenon::internal {

/// "cart.x.velocity": the path of every number of the sources, in order.
std::vector<std::string> NumberNames(const Context& context, const std::vector<const Source*>& sources);

/// All numbers of the sources in a row, as EvalDoubles gives them.
Eigen::VectorXd EvalNumbers(Context& context, const std::vector<const Source*>& sources);

/// The real numbers of some settable sources as one vector: what a central difference can move. Bools,
/// integers, enumerations and whatever is no number stay as the context has them.
class RealNumbers {
 public:
  RealNumbers(const Context& context, std::vector<const Source*> sources);

  Eigen::Index size() const { return static_cast<Eigen::Index>(names_.size()); }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<std::string>& units() const { return units_; }
  /// Throws RunError that names the source if it holds another number of numbers than at first.
  Eigen::VectorXd Get(Context& context) const;
  /// Throws RunError as SetDoubles does.
  void Set(Context& context, const Eigen::VectorXd& values) const;

 private:
  struct Part {
    const Source* source;
    std::vector<bool> is_real;  ///< of each of its numbers
  };
  std::vector<double> Eval(Context& context, const Part& part) const;

  std::vector<Part> parts_;
  std::vector<std::string> names_;
  std::vector<std::string> units_;
};

}  // namespace tenon::internal
