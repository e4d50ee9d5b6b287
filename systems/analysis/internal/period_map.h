#pragma once

#include <tenon/systems/analysis/internal/numbers.h>
#include <tenon/systems/analysis/linearize_discrete.h>
#include <tenon/systems/framework/block/internal/rational.h>

#include <Eigen/Core>

#include <functional>
#include <memory>
#include <vector>

namespace tenon {

class Simulator;

namespace internal {

/// options.period, or the common period of all sample times if that is 0; throws ParameterError as
/// LinearizeDiscrete does.
double PeriodOf(const Diagram& diagram, const LinearizeDiscreteOptions& options);

/// The same for runs that publish nothing.
LinearizeDiscreteOptions Silent(LinearizeDiscreteOptions options);

/// Simulator::AdvanceToBefore; throws RunError if a monitor ends the run.
void RunToBefore(Simulator& simulator, double time);

/// What a diagram does from before one tick to before that one period later.
class PeriodMap {
 public:
  PeriodMap(const Context& context, std::vector<const Source*> inputs, std::vector<const Source*> outputs,
            const LinearizeDiscreteOptions& options);

  /// States, then inputs; how far to move each of them per unit of a step.
  Eigen::VectorXd origin, scales;
  double time = 0, period = 0;
  const LinearizeDiscreteOptions& options() const { return options_; }
  const RealNumbers& states() const { return *states_; }
  const RealNumbers& inputs() const { return *inputs_; }

  /// Derivatives of the continuous ones of the states where the period begins; of the others 0.
  Eigen::VectorXd Rates() const;

  struct End {
    Eigen::VectorXd x1, y;
    std::unique_ptr<Context> context;
  };
  End Run(const Eigen::VectorXd& from) const;
  /// What is no real number and differs between two ends.
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
  bool ticks_ = false;  ///< something is due where the period begins
};

/// The map's derivative by central differences; x1 is passed through `bring_back` first, in every run.
DiscreteLinearModel LinearizePeriod(const PeriodMap& map,
                                    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& bring_back);

}  // namespace internal
}  // namespace tenon
