#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/simulation/internal/sundials_solver.h>

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <fmt/core.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cstdio>  // arkode_butcher.h uses FILE without it
#include <cstdlib>
#include <initializer_list>
#include <new>
#include <type_traits>

// Names of functions in SUNDIALS 7 that replace those of ERKStep and ARKStep.
#if SUNDIALS_VERSION_MAJOR >= 7
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
#endif

namespace tenon::internal {

/// The functions of one solver, with common signatures; null for functions that CVODE does not have.
struct SundialsSolver::Api {
  const char* solver;  ///< prefix of its functions' names
  int (*evolve)(void*, double, N_Vector, double*, int);
  int (*set_stop_time)(void*, double);
  int (*get_errors)(void*, N_Vector);
  int (*get_weights)(void*, N_Vector);
  int (*get_time)(void*, double*);
  int (*get_current_step)(void*, double*);
  int (*get_last_step)(void*, double*);
  int (*get_steps)(void*, long*);
  int (*get_failed_steps)(void*, long*);
  char* (*flag_name)(long);
  void (*free)(void**);
  int (*set_client)(void*, void*);
  int (*set_tolerances)(void*, double, N_Vector);
  int (*set_max_steps)(void*, long);
  int (*set_max_error_failures)(void*, int);
  int (*reset)(void*, double, N_Vector);
  int (*set_fixed_step)(void*, double) = nullptr;
  int (*set_first_step)(void*, double) = nullptr;
  int (*set_step_chooser)(void*, ARKAdaptFn, void*) = nullptr;
  int (*set_fixed_step_bounds)(void*, double, double) = nullptr;
  int (*set_safety_factor)(void*, double) = nullptr;
  int (*set_error_bias)(void*, double) = nullptr;
  int (*set_min_reduction)(void*, double) = nullptr;
  int (*set_max_growth)(void*, double) = nullptr;
  int (*set_max_first_growth)(void*, double) = nullptr;

  static const Api kErk, kArk, kCvode;
  static const Api& Of(Method method) {
    return IsExplicit(method) ? kErk : method == Method::kDirk ? kArk : kCvode;
  }
};

// The functions of the solver whose names begin with P.
#define TENON_COMMON(P)                                                                                      \
  .set_stop_time = P##SetStopTime, .get_errors = P##GetEstLocalErrors, .get_weights = P##GetErrWeights,      \
  .get_time = P##GetCurrentTime, .get_current_step = P##GetCurrentStep, .get_last_step = P##GetLastStep,     \
  .get_steps = P##GetNumSteps, .get_failed_steps = P##GetNumErrTestFails, .flag_name = P##GetReturnFlagName, \
  .free = P##Free, .set_client = P##SetUserData, .set_tolerances = P##SVtolerances,                          \
  .set_max_steps = P##SetMaxNumSteps, .set_max_error_failures = P##SetMaxErrTestFails
#define TENON_RUNGE_KUTTA(P)                                                              \
  .reset = P##Reset, .set_fixed_step = P##SetFixedStep, .set_first_step = P##SetInitStep, \
  .set_step_chooser = P##SetAdaptivityFn, .set_fixed_step_bounds = P##SetFixedStepBounds, \
  .set_safety_factor = P##SetSafetyFactor, .set_error_bias = P##SetErrorBias,             \
  .set_min_reduction = P##SetMinReduction, .set_max_growth = P##SetMaxGrowth,             \
  .set_max_first_growth = P##SetMaxFirstGrowth
const SundialsSolver::Api SundialsSolver::Api::kErk{
    .solver = "ERKStep", .evolve = ERKStepEvolve, TENON_COMMON(ERKStep), TENON_RUNGE_KUTTA(ERKStep)};
const SundialsSolver::Api SundialsSolver::Api::kArk{
    .solver = "ARKStep", .evolve = ARKStepEvolve, TENON_COMMON(ARKStep), TENON_RUNGE_KUTTA(ARKStep)};
const SundialsSolver::Api SundialsSolver::Api::kCvode{
    .solver = "CVode", .evolve = CVode, TENON_COMMON(CVode), .reset = CVodeReInit};
#undef TENON_COMMON
#undef TENON_RUNGE_KUTTA

namespace {

// Explicit Runge-Kutta pairs. The error estimate of a step is a sum of derivatives at its stages with weights
// e = b - d that add up to 0. A jump of the derivative inside the step contributes to it with the sum of the
// weights after the jump; these sums are given below, for the largest error of the step first. No sum may be
// close to 0, or a jump could stay undetected.
//
// SUNDIALS's own tables of order 2 and 3 are not used: ERKStep 6.4 wrongly uses the last stage of Heun-Euler
// as the first of the next step, and Bogacki and Shampine's estimate weights a jump in the third quarter of a
// step, which causes an error of 0.19, with only 1/72.

/// Makes a table from the entries of `a` below the diagonal, row by row, the weights b, and the weights d of
/// the embedded method.
ARKodeButcherTable Table(int order, int embedded, std::initializer_list<double> a,
                         std::initializer_list<double> b, std::initializer_list<double> d) {
  ARKodeButcherTable table = ARKodeButcherTable_Alloc(static_cast<int>(b.size()), SUNTRUE);
  if (table == nullptr) throw std::bad_alloc();
  table->q = order;
  table->p = embedded;
  const double* next = a.begin();
  for (int i = 1; i < table->stages; ++i) {
    for (int j = 0; j < i; ++j) table->c[i] += table->A[i][j] = *next++;
  }
  std::copy(b.begin(), b.end(), table->b);
  std::copy(d.begin(), d.end(), table->d);
  return table;
}

/// Explicit midpoint with a stage at the end of the step, reused as the first of the next step.
/// e = (-1, 2, -1) is a second difference, large enough for the accumulated error of many steps. Jumps cause
/// errors of up to 1/2 and have a weight of 1 in the estimate.
ARKodeButcherTable MidpointTable() {
  return Table(2, 1, {0.5, 0, 1}, {0, 1, 0}, {1, -1, 1});
}

/// The method of Bogacki and Shampine ("A 3(2) pair of Runge-Kutta formulas", Appl. Math. Lett. 2, 1989),
/// with an embedded method of order 2 whose estimate is a second difference, e = (-1, 2, 0, -1)/12, as large
/// as theirs on smooth solutions. Jumps cause errors of up to 0.28 and have a weight of 1/12 in the estimate.
ARKodeButcherTable BogackiShampineTable() {
  return Table(3, 2, {0.5, 0, 0.75, 2.0 / 9, 1.0 / 3, 4.0 / 9}, {2.0 / 9, 1.0 / 3, 4.0 / 9, 0},
               {2.0 / 9 + 1.0 / 12, 1.0 / 3 - 1.0 / 6, 4.0 / 9, 1.0 / 12});
}

// Open tables have no stage at the end of a step. They do not sample its last part, and are meant for steps
// that end at a tick which restarts the integrator.

/// Explicit midpoint with Euler embedded.
ARKodeButcherTable OpenMidpointTable() {
  return Table(2, 1, {0.5}, {0, 1}, {1, 0});
}

/// Ralston's method of order 3, the first three stages of Bogacki-Shampine, with an embedded method of order
/// 2.
ARKodeButcherTable RalstonTable() {
  return Table(3, 2, {0.5, 0, 0.75}, {2.0 / 9, 1.0 / 3, 4.0 / 9}, {1.0 / 6, 1.0 / 2, 1.0 / 3});
}

// Stabilized methods have one stage more than their order requires, to extend the stability region. For
// x' = s x, a step of h multiplies x by R(h s). |R| <= 1 for h s from -2 (midpoint) or -2.5 (Ralston) to 0.
// The closed variants have a further stage at the end of the step, which the next step reuses.

/// Order 2 in three stages, like Heun's method of order 3 with R(z) = 1 + z + z²/2 + z³/14: stable from
/// -5.36.
ARKodeButcherTable OpenStabilizedTable2() {
  return Table(2, 2, {1.0 / 3, 8.0 / 21, 2.0 / 7}, {1.0 / 4, 0, 3.0 / 4}, {1.0 / 16, 3.0 / 8, 9.0 / 16});
}
/// e = (-2, 3, 0, -1) 3/8, large enough for the accumulated error of many steps. Jumps cause errors of up to
/// 0.42 and have a weight of 3/8 in the estimate.
ARKodeButcherTable StabilizedTable2() {
  return Table(2, 1, {1.0 / 3, 8.0 / 21, 2.0 / 7, 1.0 / 4, 0, 3.0 / 4}, {1.0 / 4, 0, 3.0 / 4, 0},
               {1.0 / 4 + 3.0 / 4, -9.0 / 8, 3.0 / 4, 3.0 / 8});
}

/// Order 3 in four stages, R(z) = 1 + z + z²/2 + z³/6 + z⁴/48: stable from -5.1.
ARKodeButcherTable OpenStabilizedTable3() {
  return Table(3, 2, {1.0 / 4, 0, 1.0 / 2, 0, 3.0 / 8, 3.0 / 8}, {2.0 / 9, 0, 1.0 / 3, 4.0 / 9},
               {1.0 / 9, 0, 2.0 / 3, 2.0 / 9});
}
/// e = (-1, 0, 2, 0, -1)/12. Jumps cause errors of up to 0.53 and have a weight of 1/12 in the estimate.
ARKodeButcherTable StabilizedTable3() {
  return Table(3, 2, {1.0 / 4, 0, 1.0 / 2, 0, 3.0 / 8, 3.0 / 8, 2.0 / 9, 0, 1.0 / 3, 4.0 / 9},
               {2.0 / 9, 0, 1.0 / 3, 4.0 / 9, 0},
               {2.0 / 9 + 1.0 / 12, 0, 1.0 / 3 - 1.0 / 6, 4.0 / 9, 1.0 / 12});
}

/// The table of an explicit method; null to use that of SUNDIALS.
ARKodeButcherTable ExplicitTable(Method method, int order, bool open) {
  if (order > 3) return nullptr;
  if (method == Method::kStabilized) {
    if (open) return order == 2 ? OpenStabilizedTable2() : OpenStabilizedTable3();
    return order == 2 ? StabilizedTable2() : StabilizedTable3();
  }
  if (method == Method::kErkOpen && open) return order == 2 ? OpenMidpointTable() : RalstonTable();
  return order == 2 ? MidpointTable() : BogackiShampineTable();
}

/// Factor by which ARKODE multiplies a step that its client chooses.
constexpr double kSafetyFactor = 0.5;

/// A step that meets a jump is rejected many times, and reduced to a fifth each time.
constexpr int kMaxErrorFailures = 50;

SundialsClient& Client(void* client) {
  return *static_cast<SundialsClient*>(client);
}
int Derivatives(double t, N_Vector y, N_Vector ydot, void* client) {
  return Client(client).Derivatives(t, NV_DATA_S(y), NV_DATA_S(ydot));
}
int Jacobian(double t, N_Vector y, N_Vector f, SUNMatrix jacobian, void* client, N_Vector, N_Vector,
             N_Vector) {
  return Client(client).Jacobian(t, NV_DATA_S(y), NV_DATA_S(f), SM_COLS_D(jacobian));
}
int ChooseStep(N_Vector, double t, double h, double, double, double error, double, double, int q, int p,
               double* next, void* client) {
  *next = Client(client).ChooseStep(t, h, error, std::min(p, q) + 1) / kSafetyFactor;
  return 0;
}

int ErrorWeights(N_Vector y, N_Vector weights, void* client) {
  Client(client).ErrorWeights(NV_DATA_S(y), NV_DATA_S(weights));
  return 0;
}

#if SUNDIALS_VERSION_MAJOR >= 7
void KeepMessage(int, const char*, const char*, const char* message, SUNErrCode, void* to, SUNContext) {
  *static_cast<std::string*>(to) = message == nullptr ? "" : message;
}
const SUNComm kNoCommunicator = SUN_COMM_NULL;
#else
void KeepMessage(int, const char*, const char*, char* message, void* to) {
  *static_cast<std::string*>(to) = message;
}
constexpr void* kNoCommunicator = nullptr;
#endif

/// Throws RunError if `flag` is negative.
void CheckFlag(int flag, const char* function, const std::string& message = "") {
  if (flag >= 0) return;
  throw RunError(fmt::format("SUNDIALS: {} failed with flag {}{}{}", function, flag,
                             message.empty() ? "" : ": ", message));
}

/// Returns the object; throws RunError if it is null.
template <class Object>
Object* Made(Object* object, const char* function) {
  if (object == nullptr) throw RunError(fmt::format("SUNDIALS: {} returned null: out of memory?", function));
  return object;
}

}  // namespace

struct SundialsSolver::Handles {
  Handles() {
    if (SUNContext_Create(kNoCommunicator, &sun) != 0) throw RunError("SUNDIALS: SUNContext_Create failed");
  }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    if (table != nullptr) ARKodeButcherTable_Free(table);
    if (linear_solver != nullptr) SUNLinSolFree(linear_solver);
    if (matrix != nullptr) SUNMatDestroy(matrix);
    if (scratch != nullptr) N_VDestroy(scratch);
    if (atol != nullptr) N_VDestroy(atol);
    if (y != nullptr) N_VDestroy(y);
    SUNContext_Free(&sun);
  }

  SUNContext sun = nullptr;
  N_Vector y = nullptr;
  N_Vector atol = nullptr;
  N_Vector scratch = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear_solver = nullptr;
  ARKodeButcherTable table = nullptr;
};

void SundialsSolver::Check(int flag, const char* function) const {
  if (flag < 0) CheckFlag(flag, (std::string(api_.solver) + function).c_str(), message_);
}

SundialsSolver::SundialsSolver(const SimulatorOptions& options, bool open, double time,
                               const std::vector<double>& absolute_tolerances, SundialsClient& client)
    : api_(Api::Of(options.method)), options_(options), handles_(std::make_unique<Handles>()) {
  const auto size = static_cast<sunindextype>(absolute_tolerances.size());
  N_Vector& y = handles_->y = Made(N_VNew_Serial(size, handles_->sun), "N_VNew_Serial");
  // cloned vectors inherit the operations
  CheckFlag(N_VEnableFusedOps_Serial(y, SUNTRUE), "N_VEnableFusedOps_Serial");
  if (IsExplicit(options.method)) UseFastOperations(y);
  N_VConst(0, y);
  states_ = NV_DATA_S(y);
  N_Vector& atol = handles_->atol = Made(N_VNew_Serial(size, handles_->sun), "N_VNew_Serial");
  std::copy(absolute_tolerances.begin(), absolute_tolerances.end(), N_VGetArrayPointer(atol));
  multistep() ? CreateMultistep(time) : CreateRungeKutta(open, time, client);
  Check(api_.set_client(memory_, &client), "SetUserData");
#if SUNDIALS_VERSION_MAJOR >= 7
  SUNContext_ClearErrHandlers(handles_->sun);
  CheckFlag(SUNContext_PushErrHandler(handles_->sun, KeepMessage, &message_), "SUNContext_PushErrHandler");
#else
  const auto set_error_handler = IsExplicit(options.method)        ? ERKStepSetErrHandlerFn
                                 : options.method == Method::kDirk ? ARKStepSetErrHandlerFn
                                                                   : CVodeSetErrHandlerFn;
  Check(set_error_handler(memory_, KeepMessage, &message_), "SetErrHandlerFn");
#endif
  if (IsExplicit(options.method) && options.fixed_step == 0) {
    Check(ERKStepWFtolerances(memory_, ErrorWeights), "WFtolerances");
  } else {
    // Errors of many CVODE steps accumulate to more than those of a Runge-Kutta method.
    const double part = multistep() ? 0.5 : 1;
    N_VScale(part, atol, atol);
    Check(api_.set_tolerances(memory_, part * options.rtol, atol), "SVtolerances");
  }
  Check(api_.set_max_steps(memory_, -1), "SetMaxNumSteps");  // the client counts steps, across restarts
  Check(api_.set_max_error_failures(memory_, kMaxErrorFailures), "SetMaxErrTestFails");
}

SundialsSolver::~SundialsSolver() {
  if (memory_ != nullptr) api_.free(&memory_);
}

void SundialsSolver::CreateRungeKutta(bool open, double time, SundialsClient& client) {
  Handles& h = *handles_;
  if (IsExplicit(options_.method)) {
    memory_ = Made(ERKStepCreate(Derivatives, time, h.y, h.sun), "ERKStepCreate");
    h.table = ExplicitTable(options_.method, options_.order, open);
    if (h.table != nullptr) {
      Check(ERKStepSetTable(memory_, h.table), "SetTable");
    } else {
      const auto number = options_.order == 4 ? ARKODE_ZONNEVELD_5_3_4 : ARKODE_DORMAND_PRINCE_7_4_5;
      Check(ERKStepSetTableNum(memory_, number), "SetTableNum");
    }
  } else {
    memory_ = Made(ARKStepCreate(nullptr, Derivatives, time, h.y, h.sun), "ARKStepCreate");
    if (options_.order == 4) {
      // The default for order 4 has no stage in the first quarter of a step, so that it cannot detect a jump
      // there.
      Check(ARKStepSetTableNum(memory_, ARKODE_ARK436L2SA_DIRK_6_3_4, ARKODE_ERK_NONE), "SetTableNum");
    } else {
      Check(ARKStepSetOrder(memory_, options_.order), "SetOrder");
    }
    CreateLinearSolver();
    Check(ARKStepSetLinearSolver(memory_, h.linear_solver, h.matrix), "SetLinearSolver");
    Check(ARKStepSetJacFn(memory_, Jacobian), "SetJacFn");
    // Update the Newton matrix with the step size. The default accepts a single iteration with a matrix for a
    // step size that differs by 20 %, based on the convergence of earlier stages, and can err by a hundred
    // tolerances.
    Check(ARKStepSetDeltaGammaMax(memory_, 1e-3), "SetDeltaGammaMax");
    // Compute the derivative at a stage from the stage equation: evaluating it would multiply the residual of
    // Newton's method by the stiffness.
    Check(ARKStepSetDeduceImplicitRhs(memory_, SUNTRUE), "SetDeduceImplicitRhs");
    Check(ARKStepSetNonlinConvCoef(memory_, 1e-3), "SetNonlinConvCoef");  // residuals accumulate
    // Judge each iteration by its own correction. A rate of convergence carried over from earlier stages
    // would accept a stage after a single iteration, beyond a kink or a jump that the iteration has not seen.
    Check(ARKStepSetNonlinCRDown(memory_, 1e100), "SetNonlinCRDown");
    if (options_.fixed_step > 0)  // a smaller step is not possible
      Check(ARKStepSetMaxNonlinIters(memory_, 10), "SetMaxNonlinIters");
  }
  if (options_.fixed_step > 0) return;
  Check(api_.set_step_chooser(memory_, ChooseStep, &client), "SetAdaptivityFn");
  Check(api_.set_fixed_step_bounds(memory_, 1, 1), "SetFixedStepBounds");
  Check(api_.set_safety_factor(memory_, kSafetyFactor), "SetSafetyFactor");
  Check(api_.set_error_bias(memory_, 1), "SetErrorBias");
  Check(api_.set_min_reduction(memory_, 1e-15), "SetMinReduction");  // to cross a jump
  Check(api_.set_max_growth(memory_, 1e15), "SetMaxGrowth");
  Check(api_.set_max_first_growth(memory_, 1e15), "SetMaxFirstGrowth");
}

void SundialsSolver::CreateMultistep(double time) {
  Handles& h = *handles_;
  h.scratch = Made(N_VClone(h.y), "N_VClone");
  memory_ = Made(CVodeCreate(options_.method == Method::kBdf ? CV_BDF : CV_ADAMS, h.sun), "CVodeCreate");
  Check(CVodeInit(memory_, Derivatives, time, h.y), "Init");
  Check(CVodeSetMaxOrd(memory_, options_.order), "SetMaxOrd");
  CreateLinearSolver();
  Check(CVodeSetLinearSolver(memory_, h.linear_solver, h.matrix), "SetLinearSolver");
  Check(CVodeSetJacFn(memory_, Jacobian), "SetJacFn");
}

void SundialsSolver::CreateLinearSolver() {
  Handles& h = *handles_;
  h.matrix = Made(SUNDenseMatrix(N_VGetLength(h.y), N_VGetLength(h.y), h.sun), "SUNDenseMatrix");
  h.linear_solver = Made(SUNLinSol_Dense(h.y, h.matrix, h.sun), "SUNLinSol_Dense");
}

void SundialsSolver::Restart(double time, double end, double step) {
  if (multistep()) {
    earlier_steps_ = steps();
    earlier_failures_ = failed_steps();
  }
  Check(api_.reset(memory_, time, handles_->y), multistep() ? "ReInit" : "Reset");
  // A stop time stays set, so an interval without end gets one that is never reached.
  constexpr double kFarAway = 1e300;
  if (!ends_by_steps()) Check(api_.set_stop_time(memory_, std::min(end, kFarAway)), "SetStopTime");
  if (multistep()) return;
  if (options_.fixed_step > 0) {
    Check(api_.set_fixed_step(memory_, step), "SetFixedStep");
  } else {
    Check(api_.set_first_step(memory_, step), "SetInitStep");
  }
}

int SundialsSolver::Step(double end, double* time) {
  static_assert(ARK_ONE_STEP == CV_ONE_STEP);
  return api_.evolve(memory_, end, handles_->y, time, ARK_ONE_STEP);
}

void SundialsSolver::SetMaxStep(double step) {
  Check(CVodeSetMaxStep(memory_, std::isinf(step) ? 0 : step), "SetMaxStep");
}

void SundialsSolver::Interpolate(double time, int num_states, double* states) {
  Check(CVodeGetDky(memory_, time, 0, handles_->scratch), "GetDky");
  std::copy_n(NV_DATA_S(handles_->scratch), num_states, states);
}

bool SundialsSolver::IsStopTime(int flag) {
  static_assert(ARK_TSTOP_RETURN == CV_TSTOP_RETURN);
  return flag == ARK_TSTOP_RETURN;
}

std::vector<double> SundialsSolver::WeightedErrors() const {
  struct Destroy {
    void operator()(N_Vector vector) const { N_VDestroy(vector); }
  };
  using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, Destroy>;
  const Vector errors(Made(N_VClone(handles_->y), "N_VClone")),
      weights(Made(N_VClone(handles_->y), "N_VClone"));
  Check(api_.get_errors(memory_, errors.get()), "GetEstLocalErrors");
  Check(api_.get_weights(memory_, weights.get()), "GetErrWeights");
  std::vector<double> weighted(static_cast<std::size_t>(N_VGetLength(handles_->y)));
  for (std::size_t i = 0; i < weighted.size(); ++i) {
    weighted[i] = std::abs(N_VGetArrayPointer(errors.get())[i] * N_VGetArrayPointer(weights.get())[i]);
  }
  return weighted;
}

template <class Number>
Number SundialsSolver::Get(int (*get)(void*, Number*), const char* function) const {
  Number number{};
  Check(get(memory_, &number), function);
  return number;
}

double SundialsSolver::current_time() const {
  return Get(api_.get_time, "GetCurrentTime");
}
double SundialsSolver::current_step() const {
  return Get(api_.get_current_step, "GetCurrentStep");
}
double SundialsSolver::last_step() const {
  return Get(api_.get_last_step, "GetLastStep");
}
int SundialsSolver::last_order() const {
  return multistep() ? Get(CVodeGetLastOrder, "GetLastOrder") : options_.order;
}
long SundialsSolver::steps() const {
  return earlier_steps_ + Get(api_.get_steps, "GetNumSteps");
}
long SundialsSolver::failed_steps() const {
  return earlier_failures_ + Get(api_.get_failed_steps, "GetNumErrTestFails");
}

std::string SundialsSolver::Describe(int flag) const {
  char* name = api_.flag_name(flag);
  const std::string text = std::string(name) + ": " + message_;
  std::free(name);
  return text;
}

}  // namespace tenon::internal
