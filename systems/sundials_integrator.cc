#include "tenon/systems/sundials_integrator.h"

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <fmt/core.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "tenon/systems/diagram.h"
#include "tenon/systems/program.h"

namespace tenon {
namespace {

constexpr double kSafety = 0.9;        // of our step size, see ChooseStep
constexpr double kArkodeSafety = 0.5;  // ARKODE multiplies a step of ours by this; it is divided out
constexpr double kMaxGrowth = 5;
constexpr double kMinShrink = 0.2;
constexpr int kMaxRefused = 50;

/// Explicit midpoint with Euler embedded. SUNDIALS's own table of order 2 (Heun-Euler) ends at abscissa 1,
/// and ERKStep 6.4 then takes the last stage for the next step's first, which it is not.
ARKodeButcherTable MidpointTable() {
  ARKodeButcherTable table = ARKodeButcherTable_Alloc(2, SUNTRUE);
  table->q = 2;
  table->p = 1;
  table->c[1] = 0.5;
  table->A[1][0] = 0.5;
  table->b[1] = 1;
  table->d[0] = 1;
  return table;
}

}  // namespace

struct SundialsIntegrator::Sundials {
  Sundials(Context& c, const SimulatorOptions& o);
  ~Sundials();
  void CreateErk();
  void CreateDirk();
  void CreateCvode();
  void CheckOptions() const;
  std::vector<double> AbsoluteTolerances() const;
  void Restart(double end);
  Stop Advance(bool one_step);
  void LoadState();
  void StoreState(double t);
  [[noreturn]] void ThrowFailure(int flag);
  std::string DescribeWorstState(int flag, double h);
  void FindWorstState();
  double FirstStep() const;
  void Count(double step);
  IntegratorStatistics Statistics() const;

  static int Rhs(double t, N_Vector y, N_Vector ydot, void* self);
  static int Roots(double t, N_Vector y, double* g, void* self);
  static int ChooseStep(N_Vector y, double t, double h1, double h2, double h3, double e1, double e2,
                        double e3, int q, int p, double* next, void* self);
  static void Silent(int, const char*, const char*, char* message, void* self) {
    static_cast<Sundials*>(self)->message = message;
  }
  bool erk() const { return options.method == Method::kErk; }
  bool dirk() const { return options.method == Method::kDirk; }
  bool cvode() const { return !erk() && !dirk(); }

  Context& context;
  const internal::Program& program;
  SimulatorOptions options;
  int size;  // of the SUNDIALS vector: at least 1
  SUNContext sun = nullptr;
  N_Vector y = nullptr;  // of a diagram without states, but with witnesses of time, one entry that is 0
  N_Vector atol = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver solver = nullptr;
  ARKodeButcherTable table = nullptr;
  void* memory = nullptr;

  double end = 0;
  double step = 0;  // the first one after the restart; if fixed, all
  int refused = 0;  // evaluations since the restart that were not finite
  struct {
    int index = 0;
    double error = 0;
  } worst;
  bool seeks_worst = false;
  bool first_evaluation = false;
  bool at_end = false;  // the last evaluation was for the end of the interval
  std::vector<int> roots;
  std::vector<int> directions;
  std::exception_ptr thrown;
  std::string not_finite;
  std::string message;
  long evaluations = 0;
  long earlier_steps = 0, earlier_failures = 0;  // CVodeReInit sets its counters back
  double last_step = 0, smallest_step = 0, largest_step = 0;
};

SundialsIntegrator::Sundials::Sundials(Context& c, const SimulatorOptions& o)
    : context(c), program(c.diagram().program()), options(o), size(std::max(1, program.num_continuous)) {
  CheckOptions();
  const std::vector<double> tolerances = AbsoluteTolerances();  // throws, so before anything is there to free
  SUNContext_Create(nullptr, &sun);
  y = N_VNew_Serial(size, sun);
  N_VConst(0, y);
  LoadState();
  atol = N_VNew_Serial(size, sun);
  std::copy(tolerances.begin(), tolerances.end(), N_VGetArrayPointer(atol));
  roots.assign(program.witness_plans.size(), 0);
  for (const internal::WitnessPlan& plan : program.witness_plans) {
    const Crossing crossing = static_cast<const Witness*>(plan.witness)->crossing();
    directions.push_back(crossing == Crossing::kRising ? 1 : crossing == Crossing::kFalling ? -1 : 0);
  }
  if (erk()) CreateErk();
  if (dirk()) CreateDirk();
  if (cvode()) CreateCvode();
}

SundialsIntegrator::Sundials::~Sundials() {
  if (memory != nullptr) {
    if (erk()) ERKStepFree(&memory);
    if (dirk()) ARKStepFree(&memory);
    if (cvode()) CVodeFree(&memory);
  }
  if (table != nullptr) ARKodeButcherTable_Free(table);
  if (solver != nullptr) SUNLinSolFree(solver);
  if (matrix != nullptr) SUNMatDestroy(matrix);
  if (atol != nullptr) N_VDestroy(atol);
  if (y != nullptr) N_VDestroy(y);
  SUNContext_Free(&sun);
}

void SundialsIntegrator::Sundials::CheckOptions() const {
  const auto demand = [](bool holds, const std::string& text) {
    if (!holds) throw ParameterError("SimulatorOptions: " + text);
  };
  const int lowest = cvode() ? 1 : 2;
  const int highest = options.method == Method::kAdams ? 12 : 5;
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
  demand(options.fixed_step == 0 || !cvode(),
         "fixed_step is for Runge-Kutta methods: CVODE chooses its steps");
}

std::vector<double> SundialsIntegrator::Sundials::AbsoluteTolerances() const {
  std::vector<double> tolerances(static_cast<std::size_t>(size), options.atol);
  const std::vector<std::string> names = context.diagram().ContinuousStateNames();
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

void SundialsIntegrator::Sundials::CreateErk() {
  memory = ERKStepCreate(Rhs, context.time(), y, sun);
  ERKStepSetUserData(memory, this);
  ERKStepSetErrHandlerFn(memory, Silent, this);
  switch (options.order) {
    case 2:
      table = MidpointTable();
      ERKStepSetTable(memory, table);
      break;
    case 3:
      ERKStepSetTableNum(memory, ARKODE_BOGACKI_SHAMPINE_4_2_3);
      break;
    case 4:
      ERKStepSetTableNum(memory, ARKODE_ZONNEVELD_5_3_4);
      break;
    default:
      ERKStepSetTableNum(memory, ARKODE_DORMAND_PRINCE_7_4_5);
  }
  ERKStepSVtolerances(memory, options.rtol, atol);
  ERKStepSetMaxNumSteps(memory, options.max_steps);
  if (options.fixed_step == 0) {
    ERKStepSetAdaptivityFn(memory, ChooseStep, this);
    ERKStepSetFixedStepBounds(memory, 1, 1);
    ERKStepSetSafetyFactor(memory, kArkodeSafety);
    ERKStepSetErrorBias(memory, 1);
    ERKStepSetMaxGrowth(memory, 1e6);
    ERKStepSetMaxFirstGrowth(memory, 1e6);
  }
  if (!roots.empty()) {
    ERKStepRootInit(memory, static_cast<int>(roots.size()), Roots);
    ERKStepSetRootDirection(memory, directions.data());
  }
}

void SundialsIntegrator::Sundials::CreateDirk() {
  memory = ARKStepCreate(nullptr, Rhs, context.time(), y, sun);
  ARKStepSetUserData(memory, this);
  ARKStepSetErrHandlerFn(memory, Silent, this);
  ARKStepSetOrder(memory, options.order);
  ARKStepSVtolerances(memory, options.rtol, atol);
  ARKStepSetMaxNumSteps(memory, options.max_steps);
  matrix = SUNDenseMatrix(size, size, sun);
  solver = SUNLinSol_Dense(y, matrix, sun);
  ARKStepSetLinearSolver(memory, solver, matrix);
  // The matrix follows the step size: the default accepts one iteration with a matrix for steps 20 % off, on
  // the strength of how well earlier stages converged, and errs by a hundred tolerances.
  ARKStepSetDeltaGammaMax(memory, 1e-3);
  if (options.fixed_step == 0) {
    ARKStepSetAdaptivityFn(memory, ChooseStep, this);
    ARKStepSetFixedStepBounds(memory, 1, 1);
    ARKStepSetSafetyFactor(memory, kArkodeSafety);
    ARKStepSetErrorBias(memory, 1);
    ARKStepSetMaxGrowth(memory, 1e6);
    ARKStepSetMaxFirstGrowth(memory, 1e6);
  } else {
    ARKStepSetMaxNonlinIters(memory, 10);  // a smaller step is no remedy here
  }
  if (!roots.empty()) {
    ARKStepRootInit(memory, static_cast<int>(roots.size()), Roots);
    ARKStepSetRootDirection(memory, directions.data());
  }
}

void SundialsIntegrator::Sundials::CreateCvode() {
  memory = CVodeCreate(options.method == Method::kBdf ? CV_BDF : CV_ADAMS, sun);
  CVodeInit(memory, Rhs, context.time(), y);
  CVodeSetUserData(memory, this);
  CVodeSetErrHandlerFn(memory, Silent, this);
  CVodeSVtolerances(memory, options.rtol, atol);
  CVodeSetMaxOrd(memory, options.order);
  CVodeSetMaxNumSteps(memory, options.max_steps);
  if (options.max_step > 0) CVodeSetMaxStep(memory, options.max_step);
  matrix = SUNDenseMatrix(size, size, sun);
  solver = SUNLinSol_Dense(y, matrix, sun);
  CVodeSetLinearSolver(memory, solver, matrix);
  if (!roots.empty()) {
    CVodeRootInit(memory, static_cast<int>(roots.size()), Roots);
    CVodeSetRootDirection(memory, directions.data());
  }
}

/// Divides what is left of the interval evenly into steps no larger than `wanted`: no sliver at the end.
static double EvenStep(double remaining, double wanted) {
  const double count = std::ceil(remaining / wanted * (1 - 1e-9));
  return remaining / std::max(1.0, count);
}

double SundialsIntegrator::Sundials::FirstStep() const {
  const double remaining = end - context.time();
  double wanted = options.fixed_step > 0 ? options.fixed_step : context.next_step_;
  if (wanted <= 0) wanted = std::min(remaining, 1e-3);  // nothing known yet; the error test corrects it
  if (options.max_step > 0) wanted = std::min(wanted, options.max_step);
  return EvenStep(remaining, wanted);
}

void SundialsIntegrator::Sundials::Restart(double to) {
  end = to;
  step = FirstStep();
  first_evaluation = true;
  LoadState();
  const double t = context.time();
  refused = 0;
  if (erk()) {
    ERKStepReset(memory, t, y);
    ERKStepSetStopTime(memory, end);
    options.fixed_step > 0 ? ERKStepSetFixedStep(memory, step) : ERKStepSetInitStep(memory, step);
  } else if (dirk()) {
    ARKStepReset(memory, t, y);
    ARKStepSetStopTime(memory, end);
    options.fixed_step > 0 ? ARKStepSetFixedStep(memory, step) : ARKStepSetInitStep(memory, step);
  } else {
    long steps = 0, failures = 0;
    CVodeGetNumSteps(memory, &steps);
    CVodeGetNumErrTestFails(memory, &failures);
    earlier_steps += steps;
    earlier_failures += failures;
    CVodeReInit(memory, t, y);
    CVodeSetStopTime(memory, end);
  }
}

void SundialsIntegrator::Sundials::LoadState() {
  std::copy_n(context.continuous_data(), program.num_continuous, N_VGetArrayPointer(y));
}

/// Moves the context to `t` and y. If that is where the last derivatives were evaluated, as it is with most
/// Runge-Kutta methods at the end of an interval, then what they took to compute stays fresh for the tick.
void SundialsIntegrator::Sundials::StoreState(double t) {
  const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(program.num_continuous);
  const bool there = at_end && t == context.time() &&
                     std::memcmp(context.continuous_data(), N_VGetArrayPointer(y), bytes) == 0;
  if (there) return;
  std::copy_n(N_VGetArrayPointer(y), program.num_continuous, context.continuous_data());
  context.SetRunTime(t);
}

SundialsIntegrator::Stop SundialsIntegrator::Sundials::Advance(bool one_step) {
  double t = context.time();
  thrown = nullptr;
  not_finite.clear();
  int flag = 0;
  if (erk()) {
    flag = ERKStepEvolve(memory, end, y, &t, one_step ? ARK_ONE_STEP : ARK_NORMAL);
  } else if (dirk()) {
    flag = ARKStepEvolve(memory, end, y, &t, one_step ? ARK_ONE_STEP : ARK_NORMAL);
  } else {
    flag = CVode(memory, end, y, &t, one_step ? CV_ONE_STEP : CV_NORMAL);
  }
  if (flag < 0) ThrowFailure(flag);
  const bool root = flag == ARK_ROOT_RETURN;  // the same number in CVODE
  const bool arrived = !root && (flag == ARK_TSTOP_RETURN || t >= end);
  StoreState(arrived ? end : t);
  if (cvode()) {
    double h = 0;
    CVodeGetLastStep(memory, &h);
    Count(h);
  } else if (options.fixed_step > 0) {
    Count(step);
  }
  if (!root) return arrived ? Stop::kArrived : Stop::kStep;
  if (erk()) ERKStepGetRootInfo(memory, roots.data());
  if (dirk()) ARKStepGetRootInfo(memory, roots.data());
  if (cvode()) CVodeGetRootInfo(memory, roots.data());
  return Stop::kRoot;
}

void SundialsIntegrator::Sundials::Count(double step) {
  last_step = step;
  largest_step = std::max(largest_step, step);
  smallest_step = smallest_step == 0 ? step : std::min(smallest_step, step);
}

int SundialsIntegrator::Sundials::Rhs(double t, N_Vector y, N_Vector ydot, void* self_pointer) {
  auto& self = *static_cast<Sundials*>(self_pointer);
  Context& context = self.context;
  ++self.evaluations;
  const int size = self.program.num_continuous;
  if (size == 0) {
    N_VGetArrayPointer(ydot)[0] = 0;
    return 0;
  }
  // At the start of an interval, what the tick has just computed is not computed again; what is computed at
  // its end is kept for the next tick. Sums of steps miss the end by their rounding.
  const bool first = self.first_evaluation && t == context.time();
  self.first_evaluation = false;
  self.at_end = !first && std::abs(t - self.end) <= 1e-14 * (1 + std::abs(self.end));
  double* derivatives = N_VGetArrayPointer(ydot);
  try {
    if (first || self.at_end) {
      std::copy_n(N_VGetArrayPointer(y), size, context.continuous_data());
      if (self.at_end) context.SetRunTime(self.end);
      context.RunStale(self.program.derivatives);
      std::copy_n(context.derivative_data(), size, derivatives);
    } else {
      context.CalcTimeDerivatives(t, N_VGetArrayPointer(y), derivatives);
    }
  } catch (...) {
    self.thrown = std::current_exception();
    return -1;
  }
  double sum = 0;
  for (int i = 0; i < size; ++i) sum += derivatives[i] * 0;
  if (sum == 0) {
    self.not_finite.clear();
    return 0;
  }
  self.not_finite = fmt::format("{} at t = {} s", context.DescribeNonFinite(), t);
  // A smaller step may help, but not for ever: step sizes have no lower bound.
  return first || ++self.refused > kMaxRefused ? -1 : 1;
}

int SundialsIntegrator::Sundials::Roots(double t, N_Vector y, double* g, void* self_pointer) {
  auto& self = *static_cast<Sundials*>(self_pointer);
  Context& context = self.context;
  try {
    const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(self.program.num_continuous);
    if (bytes > 0) std::memmove(context.continuous_data(), N_VGetArrayPointer(y), bytes);
    const double now = context.time();
    *reinterpret_cast<double*>(context.memory_.get()) = t;
    context.RunAll(self.program.witnesses);
    ++context.instant_;  // what was computed here is not for the time of the tick
    *reinterpret_cast<double*>(context.memory_.get()) = now;
  } catch (...) {
    self.thrown = std::current_exception();
    return -1;
  }
  for (std::size_t i = 0; i < self.roots.size(); ++i) {
    g[i] = *reinterpret_cast<const double*>(context.Address(*self.program.witness_plans[i].witness));
  }
  return 0;
}

/// PI control of the step (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4 and II,
/// IV.2), with its memory in the context; then the rest of the interval is divided evenly.
int SundialsIntegrator::Sundials::ChooseStep(N_Vector, double t, double h1, double, double, double e1, double,
                                             double, int q, int p, double* next, void* self_pointer) {
  auto& self = *static_cast<Sundials*>(self_pointer);
  Context& context = self.context;
  const double order = std::min(p, q) + 1;
  // A step cut short by the end of its interval says little of the next one.
  const bool cut = t >= self.end - 1e-12 * (1 + std::abs(t)) && h1 < 0.5 * context.next_step_;
  const double error = std::max(e1, 1e-10);
  double factor = kSafety * std::pow(error, -0.7 / order);
  const bool accepted = e1 <= 1;
  if (accepted) {
    if (context.last_error_ > 0) factor *= std::pow(context.last_error_, 0.4 / order);
    if (!cut) context.last_error_ = error;
    if (self.seeks_worst) self.FindWorstState();
    self.Count(h1);
  } else {
    factor = std::min(kSafety, kSafety * std::pow(error, -1 / order));
  }
  double wanted = h1 * std::clamp(factor, kMinShrink, kMaxGrowth);
  if (accepted && cut) wanted = std::max(wanted, context.next_step_);
  if (self.options.max_step > 0) wanted = std::min(wanted, self.options.max_step);
  context.next_step_ = wanted;
  const double remaining = self.end - t;
  const double step = remaining > 1e-12 * (1 + std::abs(t)) ? EvenStep(remaining, wanted) : wanted;
  *next = step / kArkodeSafety;
  return 0;
}

/// The state with the largest error estimate in units of its tolerance; where there is no estimate, the one
/// that changes most in a step of `h`.
std::string SundialsIntegrator::Sundials::DescribeWorstState(int flag, double h) {
  if (program.num_continuous == 0) return "none";
  worst = {};
  if (cvode() || flag == ARK_ERR_FAILURE) {
    FindWorstState();
  } else if (flag == ARK_TOO_MUCH_WORK && options.fixed_step == 0) {
    // ARKODE keeps no estimate from step to step: ChooseStep looks at that of one step more.
    seeks_worst = true;
    erk() ? ERKStepEvolve(memory, end, y, &h, ARK_ONE_STEP) : ARKStepEvolve(memory, end, y, &h, ARK_ONE_STEP);
    seeks_worst = false;
  }
  const std::vector<std::string> names = context.diagram().ContinuousStateNames();
  if (worst.error > 0)
    return fmt::format("'{}' (error {:.3g} times its tolerance)", names[worst.index], worst.error);
  const double* derivatives = context.derivative_data();
  for (int i = 0; i < program.num_continuous; ++i) {
    const double tolerance =
        options.rtol * std::abs(context.continuous_data()[i]) + N_VGetArrayPointer(atol)[i];
    const double change = std::abs(h * derivatives[i]) / tolerance;
    if (change > worst.error) worst = {i, change};
  }
  return fmt::format("'{}' (changes by {:.3g} times its tolerance in that step)", names[worst.index],
                     worst.error);
}

void SundialsIntegrator::Sundials::FindWorstState() {
  N_Vector errors = N_VClone(y), weights = N_VClone(y);
  if (erk()) ERKStepGetEstLocalErrors(memory, errors), ERKStepGetErrWeights(memory, weights);
  if (dirk()) ARKStepGetEstLocalErrors(memory, errors), ARKStepGetErrWeights(memory, weights);
  if (cvode()) CVodeGetEstLocalErrors(memory, errors), CVodeGetErrWeights(memory, weights);
  for (int i = 0; i < program.num_continuous; ++i) {
    const double error = std::abs(N_VGetArrayPointer(errors)[i] * N_VGetArrayPointer(weights)[i]);
    if (error > worst.error) worst = {i, error};
  }
  N_VDestroy(errors);
  N_VDestroy(weights);
}

void SundialsIntegrator::Sundials::ThrowFailure(int flag) {
  ++context.instant_;  // the context holds values of different times
  if (thrown) std::rethrow_exception(thrown);
  if (!not_finite.empty()) {
    throw RunError(fmt::format("{}: the run cannot go on; check that block and what feeds it", not_finite));
  }
  char* name = cvode() ? CVodeGetReturnFlagName(flag)
                       : (erk() ? ERKStepGetReturnFlagName(flag) : ARKStepGetReturnFlagName(flag));
  const std::string flag_name = name, text = message;
  std::free(name);
  double t = 0, h = 0;
  if (erk()) ERKStepGetCurrentTime(memory, &t), ERKStepGetCurrentStep(memory, &h);
  if (dirk()) ARKStepGetCurrentTime(memory, &t), ARKStepGetCurrentStep(memory, &h);
  if (cvode()) CVodeGetCurrentTime(memory, &t), CVodeGetCurrentStep(memory, &h);
  throw RunError(
      fmt::format("the integrator fails at t = {} s with a step of {:.3g} s, rtol {:g}: worst state {} [{}: "
                  "{}]. Loosen the "
                  "tolerance, or use Method::kBdf or kDirk if the system is stiff",
                  t, h, options.rtol, DescribeWorstState(flag, h), flag_name, text));
}

IntegratorStatistics SundialsIntegrator::Sundials::Statistics() const {
  IntegratorStatistics result{.evaluations = evaluations,
                              .last_step = last_step,
                              .smallest_step = smallest_step,
                              .largest_step = largest_step,
                              .last_order = options.order};
  if (erk())
    ERKStepGetNumSteps(memory, &result.steps), ERKStepGetNumErrTestFails(memory, &result.failed_steps);
  if (dirk())
    ARKStepGetNumSteps(memory, &result.steps), ARKStepGetNumErrTestFails(memory, &result.failed_steps);
  if (cvode()) {
    CVodeGetNumSteps(memory, &result.steps);
    CVodeGetNumErrTestFails(memory, &result.failed_steps);
    CVodeGetLastOrder(memory, &result.last_order);
    result.steps += earlier_steps;
    result.failed_steps += earlier_failures;
  }
  return result;
}

SundialsIntegrator::SundialsIntegrator(Context& context, const SimulatorOptions& options)
    : sundials_(std::make_unique<Sundials>(context, options)) {}
SundialsIntegrator::~SundialsIntegrator() = default;
void SundialsIntegrator::Restart(double end) {
  sundials_->Restart(end);
}
SundialsIntegrator::Stop SundialsIntegrator::Advance(bool one_step) {
  return sundials_->Advance(one_step);
}
const std::vector<int>& SundialsIntegrator::roots() const {
  return sundials_->roots;
}
IntegratorStatistics SundialsIntegrator::statistics() const {
  return sundials_->Statistics();
}

}  // namespace tenon
