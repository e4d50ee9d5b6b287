#include <tenon/systems/analysis/analysis.h>

#include <fmt/core.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/NonLinearOptimization>

#include <tenon/systems/analysis/internal/numbers.h>

namespace tenon {
namespace {

/// Continuous states and the real numbers of chosen inputs as one vector.
class Variables {
 public:
  Variables(Context& context, std::vector<const Source*> inputs)
      : context_(context), inputs_(context, std::move(inputs)) {}
  const std::vector<std::string>& InputNames() const { return inputs_.names(); }
  Eigen::VectorXd Inputs() const { return inputs_.Get(context_); }
  void SetInputs(const Eigen::VectorXd& values) { inputs_.Set(context_, values); }
  void Set(const Eigen::VectorXd& all) {
    const Eigen::Index states = context_.continuous_state().size();
    context_.SetContinuousState(all.head(states));
    SetInputs(all.tail(all.size() - states));
  }
  Eigen::VectorXd Get() const {
    const Eigen::VectorXd states = context_.continuous_state(), inputs = Inputs();
    Eigen::VectorXd all(states.size() + inputs.size());
    all << states, inputs;
    return all;
  }

 private:
  Context& context_;
  internal::RealNumbers inputs_;
};

double Step(double value) {
  return 1e-6 * (1 + std::abs(value));
}

}  // namespace

LinearModel Linearize(const Context& original, const std::vector<const Source*>& inputs,
                      const std::vector<const Source*>& outputs) {
  if (original.diagram().num_continuous_states() == 0 && original.diagram().has_samples()) {
    throw RunError(
        "Linearize: this diagram has no continuous state, and what is sampled is held: nothing would be left "
        "of its dynamics; use LinearizeDiscrete, or linearise the plant that it belongs to");
  }
  const std::unique_ptr<Context> context = original.Clone();
  Variables variables(*context, inputs);
  const auto evaluate_outputs = [&] { return internal::EvalNumbers(*context, outputs); };
  LinearModel model;
  model.states = context->diagram().ContinuousStateNames();
  model.x0 = context->continuous_state();
  model.u0 = variables.Inputs();
  model.xdot0 = context->EvalTimeDerivatives();
  model.y0 = evaluate_outputs();
  model.inputs = variables.InputNames();
  model.outputs = internal::NumberNames(*context, outputs);

  const Eigen::Index n = model.x0.size(), m = model.u0.size(), p = model.y0.size();
  Eigen::MatrixXd dynamics(n, n + m), readout(p, n + m);
  const Eigen::VectorXd center = variables.Get();
  for (Eigen::Index i = 0; i < n + m; ++i) {
    Eigen::VectorXd point = center;
    point[i] = center[i] + Step(center[i]);
    const double above = point[i];
    variables.Set(point);
    const Eigen::VectorXd dynamics_above = context->EvalTimeDerivatives(), readout_above = evaluate_outputs();
    point[i] = center[i] - Step(center[i]);
    const double width = above - point[i];
    variables.Set(point);
    dynamics.col(i) = (dynamics_above - context->EvalTimeDerivatives()) / width;
    readout.col(i) = (readout_above - evaluate_outputs()) / width;
  }
  model.A = dynamics.leftCols(n);
  model.B = dynamics.rightCols(m);
  model.C = readout.leftCols(n);
  model.D = readout.rightCols(m);
  return model;
}

void FindEquilibrium(Context& context, const EquilibriumOptions& options) {
  struct Residual {
    Context& context;
    Variables& variables;
    int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& f) const {
      variables.Set(x);
      f.setZero();
      const Eigen::VectorXd derivatives = context.EvalTimeDerivatives();
      f.head(derivatives.size()) = derivatives;
      return 0;
    }
    int df(const Eigen::VectorXd& x, Eigen::MatrixXd& jacobian) const {
      Eigen::VectorXd above(values()), below(values());
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        Eigen::VectorXd point = x;
        point[i] = x[i] + Step(x[i]);
        const double end = point[i];
        (*this)(point, above);
        point[i] = x[i] - Step(x[i]);
        (*this)(point, below);
        jacobian.col(i) = (above - below) / (end - point[i]);
      }
      return 0;
    }
    // The method wants at least as many equations as unknowns: trim adds equations 0 = 0.
    int values() const { return inputs(); }
    int inputs() const { return static_cast<int>(variables.Get().size()); }
  };
  Variables variables(context, options.free_inputs);
  Eigen::VectorXd x = variables.Get();
  if (x.size() == 0) return;
  Residual residual{context, variables};
  Eigen::LevenbergMarquardt<Residual> solver(residual);
  solver.parameters.xtol = 1e-15;
  solver.parameters.ftol = 1e-15;
  solver.parameters.maxfev = options.max_iterations;
  solver.minimize(x);
  variables.Set(x);

  const Eigen::VectorXd derivatives = context.EvalTimeDerivatives();
  if (derivatives.norm() <= options.tolerance) return;
  Eigen::Index worst = 0;
  derivatives.cwiseAbs().maxCoeff(&worst);
  throw RunError(
      fmt::format("no equilibrium found near the given values: d/dt of '{}' stays at {:.3g}, |xdot| = {:.3g} "
                  "is above {:g}. Start "
                  "nearer, or let inputs go free",
                  context.diagram().ContinuousStateNames()[static_cast<std::size_t>(worst)],
                  derivatives[worst], derivatives.norm(), options.tolerance));
}

}  // namespace tenon
