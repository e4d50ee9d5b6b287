#pragma once

#include <tenon/systems/analysis/linearize_discrete.h>
#include <tenon/systems/framework/block/internal/rational.h>

namespace tenon {

class Simulator;

namespace internal {

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

/// Returns options.period or, if it is 0, the common period of all sample times. Throws ParameterError as
/// LinearizeDiscrete does.
double PeriodOf(const Diagram& diagram, const LinearizeDiscreteOptions& options);

/// Returns the options with publishes switched off.
LinearizeDiscreteOptions Silent(LinearizeDiscreteOptions options);

/// Calls Simulator::AdvanceToBefore. Throws RunError if a monitor ends the run.
void RunToBefore(Simulator& simulator, double time);

/// The map of a diagram's state from before a tick to before the tick one period later.
class PeriodMap {
 public:
  PeriodMap(const Context& context, std::vector<const Source*> inputs, std::vector<const Source*> outputs,
            const LinearizeDiscreteOptions& options);

  /// Scales of the states and then the inputs, by which a step is multiplied.
  Eigen::VectorXd origin, scales;
  double time = 0, period = 0;
  const LinearizeDiscreteOptions& options() const { return options_; }
  const RealNumbers& states() const { return *states_; }
  const RealNumbers& inputs() const { return *inputs_; }

  /// Returns the derivatives of the states at the begin of the period, 0 for states that are not continuous.
  Eigen::VectorXd Rates() const;

  struct End {
    Eigen::VectorXd x1, y;
    std::unique_ptr<Context> context;
  };
  End Run(const Eigen::VectorXd& from) const;
  /// Returns the values that are not real numbers and differ between two ends.
  std::vector<std::string> Flips(const End& one, const End& other) const;
  std::vector<std::string> OutputNames(const End& end) const { return NumberNames(*end.context, outputs_); }

 private:
  void FindBegin(const Context& context);
  void ChooseStates();
  void ChooseScales();
  double NextTick(int group) const;
  bool CarriesOn(int sample) const;

  const LinearizeDiscreteOptions options_;
  std::vector<const Source*> outputs_;
  std::unique_ptr<Context> start_;
  std::vector<const Source*> carriers_;
  std::unique_ptr<const RealNumbers> states_, inputs_;
  bool ticks_ = false;  ///< whether a tick is due at the begin of the period
};

/// Computes the map's derivative by central differences. In every run, `bring_back` is applied to x1 first.
DiscreteLinearModel LinearizePeriod(const PeriodMap& map,
                                    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& bring_back);

}  // namespace internal
}  // namespace tenon
