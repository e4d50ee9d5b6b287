#include <tenon/systems/simulation/internal/sundials_integrator.h>

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <tenon/systems/framework/diagram.h>
#include <tenon/systems/framework/internal/program.h>
#include <tenon/systems/simulation/internal/step_interpolant.h>
#include <tenon/systems/simulation/internal/sundials_solver.h>

namespace tenon {
namespace {

// Of the step size, see ChooseStep.
constexpr double kSafety = 0.9;
constexpr double kMaxGrowth = 5;
constexpr double kMinShrink = 0.2;
constexpr double kProportional = 0.7, kIntegral = 0.4;  // over the order: exponents of the errors
/// By order of the estimate: two errors in succession, the second no larger, that let a step grow as far as
/// it may; rounded down from (kSafety / kMaxGrowth)^(order / (kProportional - kIntegral)).
constexpr std::array<double, 6> kNegligible{0, 0, 1e-5, 3.5e-8, 1.1e-10, 0};
constexpr int kMaxRefused = 50;
constexpr double kFirstTry = 1e-3;  // s, where nothing is known; the error test corrects it

void CheckOptions(const SimulatorOptions& options) {
  const auto demand = [](bool holds, const std::string& text) {
    if (!holds) throw ParameterError("SimulatorOptions: " + text);
  };
  const bool multistep = options.method == Method::kBdf || options.method == Method::kAdams;
  const int lowest = multistep ? 1 : 2;
  const int highest = options.method == Method::kAdams ? 12 : options.method == Method::kStabilized ? 3 : 5;
  demand(options.order >= lowest && options.order <= highest,
         fmt::format("order {} does not exist for this method: choose {} to {}", options.order, lowest,
                     highest));
  demand(options.rtol > 0, fmt::format("rtol = {} must be positive", options.rtol));
  demand(options.atol > 0, fmt::format("atol = {} must be positive", options.atol));
  for (const StateTolerance& own : options.state_atol) {
    demand(own.atol > 0, fmt::format("atol = {} of '{}' must be positive", own.atol, own.prefix));
  }
  demand(options.fixed_step >= 0, fmt::format("fixed_step = {} s must not be negative", options.fixed_step));
  demand(options.max_step >= 0, fmt::format("max_step = {} s must not be negative", options.max_step));
  demand(options.fixed_step == 0 || !multistep,
         "fixed_step is for Runge-Kutta methods: CVODE chooses its steps");
}

/// One per state; a diagram without states, but with witnesses of time, gets one that stays 0.
std::vector<double> AbsoluteTolerances(const SimulatorOptions& options, const Diagram& diagram) {
  const std::vector<std::string> names = diagram.ContinuousStateNames();
  std::vector<double> tolerances(std::max<std::size_t>(1, names.size()), options.atol);
  for (const StateTolerance& own : options.state_atol) {
    bool found = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!names[i].starts_with(own.prefix)) continue;
      tolerances[i] = own.atol;
      found = true;
    }
    if (!found) {
      throw ParameterError(
          fmt::format("state_atol: no continuous state's path begins with '{}'", own.prefix));
    }
  }
  return tolerances;
}

std::vector<int> RootDirections(const internal::Program& program) {
  std::vector<int> directions;
  for (const internal::WitnessPlan& plan : program.witness_plans) {
    const Crossing crossing = static_cast<const Witness*>(plan.witness)->crossing();
    directions.push_back(crossing == Crossing::kRising ? 1 : crossing == Crossing::kFalling ? -1 : 0);
  }
  return directions;
}

/// What SUNDIALS is told of an interval without end.
constexpr double kFarAway = 1e6;  // s

bool AllFinite(const double* values, int size) {
  // The sum of 0 x is 0 unless one is not finite.
  double zero = 0;
  for (int i = 0; i < size; ++i) zero += 0 * values[i];
  return zero == 0;
}

/// Divides what is left of the interval evenly into steps no larger than `wanted`: no sliver at the end.
double EvenStep(double remaining, double wanted) {
  if (std::isinf(remaining)) return wanted;
  const double count = std::ceil(remaining / wanted * (1 - 1e-9));
  return remaining / std::max(1.0, count);
}

}  // namespace

struct SundialsIntegrator::Run final : internal::SundialsClient, internal::DerivativeSource {
  Run(Context& c, const SimulatorOptions& o)
      : context(c),
        program(c.diagram().program()),
        options((CheckOptions(o), o)),
        roots(program.witness_plans.size(), 0),
        tolerances(AbsoluteTolerances(options, c.diagram())),
        solver(options, c.time(), tolerances, RootDirections(program), *this),
        interpolant(program.num_continuous, std::max(3, options.order), options.method == Method::kDirk),
        before(static_cast<std::size_t>(program.num_continuous)) {}

  Stop Start(double to);
  void Restart(double time, double first_step);
  Stop Advance(bool one_step);
  void MoveContext(double t);
  void KeepStepStart();
  double Target() const { return std::isinf(end) ? finish + kFarAway : end; }
  bool has_past() const { return !internal::IsExplicit(options.method); }
  double FirstStep() const;
  double LargestStep(double time) const;
  void Count(double step);
  [[noreturn]] void ThrowFailure(int flag);
  std::string DescribeWorstState(int flag, double h);
  void FindWorstState();

  int Derivatives(double t, const double* y, double* ydot) override;
  int Roots(double t, const double* y, double* g) override;
  double ChooseStep(double t, double h, double error, int order) override;
  void ErrorWeights(const double* y, double* weights) override;
  void EvaluateForInterpolant(double t, const double* x, double* xdot) override;

  Context& context;
  const internal::Program& program;
  SimulatorOptions options;
  std::vector<int> roots;
  std::vector<double> tolerances;  // absolute, one per state
  internal::SundialsSolver solver;

  bool live = false;          // the solver stands at `finish` and can go on
  std::uint64_t edition = 0;  // of the context that it knows
  double finish = 0;
  internal::StepInterpolant interpolant;
  std::vector<double> before;     // the states where the last Advance began
  double begin = 0;               // and when
  bool in_step = false;           // the last Advance ended at a root, inside a step
  double end = 0;                 // of the interval
  double step = 0;                // the first one after the restart; if fixed, all
  int refused = 0;                // evaluations since the restart that were not finite
  bool first_evaluation = false;  // after the restart
  bool at_end = false;            // the last evaluation was for the end of the interval
  // The methods of order 2 and 3 have no stage at the end of a step. SUNDIALS evaluates there all the same,
  // to find roots by interpolation and to start the next step: without roots, and with a restart to come, for
  // nothing.
  const bool needs_end = has_past() || options.order > 3 || !roots.empty();
  struct {
    int index = 0;
    double error = 0;
  } worst;
  bool seeks_worst = false;
  std::exception_ptr thrown;
  std::string not_finite;
  long evaluations = 0, interpolant_evaluations = 0;
  double last_step = 0, smallest_step = 0, largest_step = 0;
};

double SundialsIntegrator::Run::FirstStep() const {
  const double remaining = end - context.time();
  double wanted = options.fixed_step > 0 ? options.fixed_step : context.next_step_;
  if (wanted <= 0) wanted = std::min(remaining, kFirstTry);
  return EvenStep(remaining, std::min(wanted, LargestStep(context.time())));
}

/// Where no tick ends the interval, a step doubles the time at most: what is exact for a while (a free fall)
/// would take steps in which roots could not be told apart.
double SundialsIntegrator::Run::LargestStep(double time) const {
  double largest = options.max_step > 0 ? options.max_step : std::numeric_limits<double>::infinity();
  if (std::isinf(end) && options.fixed_step == 0) largest = std::min(largest, kFirstTry + std::abs(time));
  return largest;
}

void SundialsIntegrator::Run::Restart(double time, double first_step) {
  step = first_step;
  first_evaluation = true;
  refused = 0;
  finish = time;
  live = true;
  in_step = false;
  edition = context.edition_;
  interpolant.Restart();
  solver.Restart(time, end, step);
}

SundialsIntegrator::Stop SundialsIntegrator::Run::Start(double to) {
  end = to;
  Context::StepStart& from = context.step_start_;
  if (!from.valid) {
    std::copy_n(context.continuous_data(), program.num_continuous, solver.states());
    Restart(context.time(), FirstStep());
    return Stop::kStep;
  }
  // The context is inside a step, or at the end of one that the solver does not know.
  const double time = context.time();
  std::copy(from.states.begin(), from.states.end(), solver.states());
  context.next_step_ = from.next_step;
  context.last_error_ = from.last_error;
  Restart(from.time, from.size);
  first_evaluation = false;  // what the context holds is of another time
  const std::vector<double> held(context.continuous_data(),
                                 context.continuous_data() + program.num_continuous);
  Stop stop = Stop::kStep;
  while (finish < time - Tiny(time)) stop = Advance(true);
  MoveContext(time);
  if (std::equal(held.begin(), held.end(), context.continuous_data())) return stop;
  // With other options it is another step: what the context held counts.
  from.valid = false;
  context.LoadStates(held.data());
  std::copy(held.begin(), held.end(), solver.states());
  context.SetRunTime(time);
  Restart(time, FirstStep());
  return Stop::kStep;
}

SundialsIntegrator::Stop SundialsIntegrator::Run::Advance(bool one_step) {
  begin = finish;
  thrown = nullptr;
  not_finite.clear();
  if (one_step) {
    std::copy_n(solver.states(), program.num_continuous, before.data());
    if (!in_step) KeepStepStart();
  } else {
    context.step_start_.valid = false;
  }
  double t = finish;
  if (solver.multistep()) solver.SetMaxStep(LargestStep(finish));
  const int flag = solver.Evolve(Target(), &t, one_step);
  if (flag < 0) ThrowFailure(flag);
  const bool root = solver.IsRoot(flag);
  const bool arrived = !root && (solver.IsStopTime(flag) || t >= end - Tiny(end));
  finish = arrived ? end : t;
  in_step = root && solver.current_time() - finish > Tiny(finish);
  if (solver.multistep()) {
    Count(solver.last_step());
  } else if (options.fixed_step > 0) {
    Count(step);
  }
  if (one_step) interpolant.SetStep(begin, before.data(), finish, solver.states());
  if (!root) return arrived ? Stop::kArrived : Stop::kStep;
  solver.GetRoots(&roots);
  return Stop::kRoot;
}

/// What it takes to come here again: of an explicit Runge-Kutta method the step, of methods with a past that
/// SUNDIALS shows nobody (Jacobians, earlier steps) everything since it started.
void SundialsIntegrator::Run::KeepStepStart() {
  Context::StepStart& from = context.step_start_;
  if (from.valid && has_past()) return;
  from.valid = true;
  from.time = begin;
  from.states = before;
  from.size = step;
  from.next_step = context.next_step_;
  from.last_error = context.last_error_;
}

/// At the finish: if that is where the last derivatives were evaluated, as it is with most Runge-Kutta
/// methods at the end of an interval, then what they took to compute stays fresh for the tick.
void SundialsIntegrator::Run::MoveContext(double t) {
  if (std::abs(t - finish) <= Tiny(t)) {
    const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(program.num_continuous);
    const bool there =
        at_end && t == context.time() && std::memcmp(context.continuous_data(), solver.states(), bytes) == 0;
    if (there) return;
    context.LoadStates(solver.states());
  } else if (solver.multistep()) {
    solver.Interpolate(t, program.num_continuous, before.data());
    context.LoadStates(before.data());
  } else {
    interpolant.At(t, *this, before.data());
    context.LoadStates(before.data());
  }
  context.SetRunTime(t);
}

void SundialsIntegrator::Run::EvaluateForInterpolant(double t, const double* x, double* xdot) {
  ++interpolant_evaluations;
  context.CalcRunDerivatives(t, x, xdot);
  if (AllFinite(xdot, program.num_continuous)) return;
  throw RunError(
      fmt::format("{} at t = {} s, inside a step of the integrator: the run cannot go on; check that "
                  "block and what feeds it",
                  context.DescribeNonFinite(), t));
}

void SundialsIntegrator::Run::Count(double step) {
  last_step = step;
  largest_step = std::max(largest_step, step);
  smallest_step = smallest_step == 0 ? step : std::min(smallest_step, step);
}

int SundialsIntegrator::Run::Derivatives(double t, const double* y, double* ydot) {
  const int size = program.num_continuous;
  if (size == 0) {
    ydot[0] = 0;
    return 0;
  }
  // At the start of an interval, what the tick has just computed is not computed again; what is computed at
  // its end is kept for the next tick. Sums of steps miss the end by their rounding.
  const bool first = first_evaluation && t == context.time();
  first_evaluation = false;
  at_end = !first && std::abs(t - end) <= Tiny(t);
  if (at_end && !needs_end) {
    at_end = false;
    std::fill_n(ydot, size, 0.0);
    return 0;
  }
  ++evaluations;
  try {
    if (first || at_end) {
      context.LoadStates(y);
      if (at_end) context.SetRunTime(end);
      context.RunStale(program.derivatives);
      context.PackDerivatives();
      std::copy_n(context.derivative_data(), size, ydot);
    } else {
      context.CalcRunDerivatives(t, y, ydot);
    }
  } catch (...) {
    thrown = std::current_exception();
    return -1;
  }
  if (AllFinite(ydot, size)) {
    not_finite.clear();
    return 0;
  }
  not_finite = fmt::format("{} at t = {} s", context.DescribeNonFinite(), t);
  // A smaller step may help, but not for ever: step sizes have no lower bound.
  return first || ++refused > kMaxRefused ? -1 : 1;
}

int SundialsIntegrator::Run::Roots(double t, const double* y, double* g) {
  try {
    context.LoadStates(y);
    const double now = context.time();
    *reinterpret_cast<double*>(context.memory_.get()) = t;
    context.RunAll(program.witnesses);
    ++context.instant_;  // what was computed here is not for the time of the tick
    *reinterpret_cast<double*>(context.memory_.get()) = now;
  } catch (...) {
    thrown = std::current_exception();
    return -1;
  }
  for (std::size_t i = 0; i < roots.size(); ++i) {
    g[i] = *reinterpret_cast<const double*>(context.Address(*program.witness_plans[i].witness));
  }
  return 0;
}

/// PI control of the step (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4 and II,
/// IV.2), with its memory in the context; then the rest of the interval is divided evenly.
double SundialsIntegrator::Run::ChooseStep(double t, double h, double measured, int order) {
  // A step cut short by the end of its interval says little of the next one.
  const bool cut = t >= end - 1e-12 * (1 + std::abs(t)) && h < 0.5 * context.next_step_;
  const double error = std::max(measured, 1e-10);
  double factor = kMaxGrowth;
  const bool accepted = measured <= 1;
  if (accepted) {
    if (!has_past()) {
      context.step_start_.size = h;
      context.step_start_.next_step = context.next_step_;
    }
    // A small error that has not grown needs no powers to know that the step grows as far as it may.
    if (error > kNegligible[static_cast<std::size_t>(order)] || error > context.last_error_) {
      factor = kSafety * std::pow(error, -kProportional / order);
      if (context.last_error_ > 0) factor *= std::pow(context.last_error_, kIntegral / order);
    }
    if (!cut) context.last_error_ = error;
    if (seeks_worst) FindWorstState();
    Count(h);
  } else {
    factor = std::min(kSafety, kSafety * std::pow(error, -1.0 / order));
  }
  double wanted = h * std::clamp(factor, kMinShrink, kMaxGrowth);
  if (accepted && cut) wanted = std::max(wanted, context.next_step_);
  wanted = std::min(wanted, LargestStep(t));
  context.next_step_ = wanted;
  const double remaining = end - t;
  return remaining > 1e-12 * (1 + std::abs(t)) ? EvenStep(remaining, wanted) : wanted;
}

void SundialsIntegrator::Run::ErrorWeights(const double* y, double* weights) {
  const double* const absolute = tolerances.data();
  double* const __restrict__ out = weights;
  const double relative = options.rtol;
  for (std::size_t i = 0; i < tolerances.size(); ++i) out[i] = 1 / (relative * std::abs(y[i]) + absolute[i]);
}

/// The state with the largest error estimate in units of its tolerance; where there is no estimate, the one
/// that changes most in a step of `h`.
std::string SundialsIntegrator::Run::DescribeWorstState(int flag, double h) {
  if (program.num_continuous == 0) return "none";
  worst = {};
  if (solver.multistep() || solver.IsErrorTestFailure(flag)) {
    FindWorstState();
  } else if (solver.IsTooMuchWork(flag) && options.fixed_step == 0) {
    // ARKODE keeps no estimate from step to step: ChooseStep looks at that of one step more.
    double t = 0;
    seeks_worst = true;
    solver.Evolve(Target(), &t, true);
    seeks_worst = false;
  }
  const std::vector<std::string> names = context.diagram().ContinuousStateNames();
  if (worst.error > 0)
    return fmt::format("'{}' (error {:.3g} times its tolerance)", names[worst.index], worst.error);
  const double* derivatives = context.derivative_data();
  for (int i = 0; i < program.num_continuous; ++i) {
    const double tolerance =
        options.rtol * std::abs(context.continuous_data()[i]) + tolerances[static_cast<std::size_t>(i)];
    const double change = std::abs(h * derivatives[i]) / tolerance;
    if (change > worst.error) worst = {i, change};
  }
  return fmt::format("'{}' (changes by {:.3g} times its tolerance in that step)", names[worst.index],
                     worst.error);
}

void SundialsIntegrator::Run::FindWorstState() {
  const std::vector<double> errors = solver.WeightedErrors();
  for (int i = 0; i < program.num_continuous; ++i) {
    if (errors[static_cast<std::size_t>(i)] > worst.error) worst = {i, errors[static_cast<std::size_t>(i)]};
  }
}

void SundialsIntegrator::Run::ThrowFailure(int flag) {
  ++context.instant_;  // the context holds values of different times
  if (thrown) std::rethrow_exception(thrown);
  if (!not_finite.empty()) {
    throw RunError(fmt::format("{}: the run cannot go on; check that block and what feeds it", not_finite));
  }
  const std::string flag_text = solver.Describe(flag);
  const double t = solver.current_time(), h = solver.current_step();
  throw RunError(fmt::format(
      "the integrator fails at t = {} s with a step of {:.3g} s, rtol {:g}: worst state {} [{}]. Loosen the "
      "tolerance, or use Method::kBdf or kDirk if the system is stiff",
      t, h, options.rtol, DescribeWorstState(flag, h), flag_text));
}

SundialsIntegrator::SundialsIntegrator(Context& context, const SimulatorOptions& options)
    : run_(std::make_unique<Run>(context, options)) {}
SundialsIntegrator::~SundialsIntegrator() = default;
bool SundialsIntegrator::can_go_on() const {
  return run_->live && run_->edition == run_->context.edition_;
}
SundialsIntegrator::Stop SundialsIntegrator::Start(double end) {
  return run_->Start(end);
}
bool SundialsIntegrator::in_step() const {
  return run_->in_step;
}
void SundialsIntegrator::Halt() {
  run_->live = false;
  run_->context.step_start_.valid = false;
}
SundialsIntegrator::Stop SundialsIntegrator::Advance(bool one_step) {
  return run_->Advance(one_step);
}
double SundialsIntegrator::finish() const {
  return run_->finish;
}
void SundialsIntegrator::MoveContext(double time) {
  run_->MoveContext(time);
}
void SundialsIntegrator::ThrowTooManySteps() {
  run_->ThrowFailure(internal::SundialsSolver::kTooMuchWork);
}
const std::vector<int>& SundialsIntegrator::roots() const {
  return run_->roots;
}

IntegratorStatistics SundialsIntegrator::statistics() const {
  return {.steps = run_->solver.steps(),
          .failed_steps = run_->solver.failed_steps(),
          .evaluations = run_->evaluations,
          .interpolant_evaluations = run_->interpolant_evaluations,
          .last_step = run_->last_step,
          .smallest_step = run_->smallest_step,
          .largest_step = run_->largest_step,
          .last_order = run_->solver.last_order()};
}

}  // namespace tenon
