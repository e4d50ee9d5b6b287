#pragma once

#include <tenon/systems/analysis/internal/numbers.h>
#include <tenon/systems/analysis/linearize_discrete.h>
#include <tenon/systems/framework/block/internal/rational.h>

namespace tenon {

class Simulator;

namespace internal {

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
