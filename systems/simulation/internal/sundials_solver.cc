#include <tenon/systems/simulation/internal/sundials_solver.h>

#include <cstdio>  // arkode_butcher.h uses FILE without it

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <initializer_list>

#include <tenon/systems/simulation/internal/sundials_vector.h>

// SUNDIALS 7 has other names for the functions of ERKStep and ARKStep, beside these.
#if SUNDIALS_VERSION_MAJOR >= 7
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"
#endif

namespace tenon::internal {

/// The functions of one solver. The same things have the same signatures in all of them; null is what CVODE
/// does not have.
struct SundialsSolver::Api {
  int (*evolve)(void*, double, N_Vector, double*, int);
  int (*set_stop_time)(void*, double);
  int (*get_roots)(void*, int*);
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
  int (*set_roots)(void*, int, ARKRootFn);
  int (*set_root_directions)(void*, int*);
  int (*reset)(void*, double, N_Vector);
  int (*set_fixed_step)(void*, double);
  int (*set_first_step)(void*, double);
  int (*set_step_chooser)(void*, ARKAdaptFn, void*);
  int (*set_fixed_step_bounds)(void*, double, double);
  int (*set_safety_factor)(void*, double);
  int (*set_error_bias)(void*, double);
  int (*set_max_growth)(void*, double);
  int (*set_max_first_growth)(void*, double);

  static const Api kErk, kArk, kCvode;
  static const Api& Of(Method method) {
    return IsExplicit(method) ? kErk : method == Method::kDirk ? kArk : kCvode;
  }
};

const SundialsSolver::Api SundialsSolver::Api::kErk{ERKStepEvolve,
                                                    ERKStepSetStopTime,
                                                    ERKStepGetRootInfo,
                                                    ERKStepGetEstLocalErrors,
                                                    ERKStepGetErrWeights,
                                                    ERKStepGetCurrentTime,
                                                    ERKStepGetCurrentStep,
                                                    ERKStepGetLastStep,
                                                    ERKStepGetNumSteps,
                                                    ERKStepGetNumErrTestFails,
                                                    ERKStepGetReturnFlagName,
                                                    ERKStepFree,
                                                    ERKStepSetUserData,
                                                    ERKStepSVtolerances,
                                                    ERKStepSetMaxNumSteps,
                                                    ERKStepRootInit,
                                                    ERKStepSetRootDirection,
                                                    ERKStepReset,
                                                    ERKStepSetFixedStep,
                                                    ERKStepSetInitStep,
                                                    ERKStepSetAdaptivityFn,
                                                    ERKStepSetFixedStepBounds,
                                                    ERKStepSetSafetyFactor,
                                                    ERKStepSetErrorBias,
                                                    ERKStepSetMaxGrowth,
                                                    ERKStepSetMaxFirstGrowth};
const SundialsSolver::Api SundialsSolver::Api::kArk{ARKStepEvolve,
                                                    ARKStepSetStopTime,
                                                    ARKStepGetRootInfo,
                                                    ARKStepGetEstLocalErrors,
                                                    ARKStepGetErrWeights,
                                                    ARKStepGetCurrentTime,
                                                    ARKStepGetCurrentStep,
                                                    ARKStepGetLastStep,
                                                    ARKStepGetNumSteps,
                                                    ARKStepGetNumErrTestFails,
                                                    ARKStepGetReturnFlagName,
                                                    ARKStepFree,
                                                    ARKStepSetUserData,
                                                    ARKStepSVtolerances,
                                                    ARKStepSetMaxNumSteps,
                                                    ARKStepRootInit,
                                                    ARKStepSetRootDirection,
                                                    ARKStepReset,
                                                    ARKStepSetFixedStep,
                                                    ARKStepSetInitStep,
                                                    ARKStepSetAdaptivityFn,
                                                    ARKStepSetFixedStepBounds,
                                                    ARKStepSetSafetyFactor,
                                                    ARKStepSetErrorBias,
                                                    ARKStepSetMaxGrowth,
                                                    ARKStepSetMaxFirstGrowth};
const SundialsSolver::Api SundialsSolver::Api::kCvode{CVode,
                                                      CVodeSetStopTime,
                                                      CVodeGetRootInfo,
                                                      CVodeGetEstLocalErrors,
                                                      CVodeGetErrWeights,
                                                      CVodeGetCurrentTime,
                                                      CVodeGetCurrentStep,
                                                      CVodeGetLastStep,
                                                      CVodeGetNumSteps,
                                                      CVodeGetNumErrTestFails,
                                                      CVodeGetReturnFlagName,
                                                      CVodeFree,
                                                      CVodeSetUserData,
                                                      CVodeSVtolerances,
                                                      CVodeSetMaxNumSteps,
                                                      CVodeRootInit,
                                                      CVodeSetRootDirection,
                                                      CVodeReInit,
                                                      nullptr,
                                                      nullptr,
                                                      nullptr,
                                                      nullptr,
                                                      nullptr,
                                                      nullptr,
                                                      nullptr,
                                                      nullptr};

namespace {

// Tables without a stage at the end of a step, for runs in which a tick changes the derivatives there. (Of
// SUNDIALS's own, Heun-Euler ends at abscissa 1, and ERKStep 6.4 then takes the last stage for the next
// step's first, which it is not; Bogacki-Shampine takes a fourth stage for its error estimate.)

/// A table of which `a` holds what lies below the diagonal, row by row; b, and d of the embedded method.
ARKodeButcherTable Table(int order, int embedded, std::initializer_list<double> a,
                         std::initializer_list<double> b, std::initializer_list<double> d) {
  ARKodeButcherTable table = ARKodeButcherTable_Alloc(static_cast<int>(b.size()), SUNTRUE);
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

/// Explicit midpoint with Euler embedded.
ARKodeButcherTable MidpointTable() {
  return Table(2, 1, {0.5}, {0, 1}, {1, 0});
}

/// Ralston's method of order 3, the first three stages of Bogacki-Shampine, with one of order 2 embedded.
ARKodeButcherTable RalstonTable() {
  return Table(3, 2, {0.5, 0, 0.75}, {2.0 / 9, 1.0 / 3, 4.0 / 9}, {1.0 / 6, 1.0 / 2, 1.0 / 3});
}

// Methods of one stage more than their order takes. It serves stability: of x' = s x, a step of h multiplies
// x by R(h s), which an explicit method keeps within 1 for h s from -2 (midpoint) or -2.5 (Ralston) to 0.

/// Order 2 in three stages, Heun's of order 3 but for R(z) = 1 + z + z²/2 + z³/14: stable from -5.36.
ARKodeButcherTable StabilizedTable2() {
  return Table(2, 2, {1.0 / 3, 8.0 / 21, 2.0 / 7}, {1.0 / 4, 0, 3.0 / 4}, {1.0 / 16, 3.0 / 8, 9.0 / 16});
}

/// Order 3 in four stages, R(z) = 1 + z + z²/2 + z³/6 + z⁴/48: stable from -5.1.
ARKodeButcherTable StabilizedTable3() {
  return Table(3, 2, {1.0 / 4, 0, 1.0 / 2, 0, 3.0 / 8, 3.0 / 8}, {2.0 / 9, 0, 1.0 / 3, 4.0 / 9},
               {1.0 / 9, 0, 2.0 / 3, 2.0 / 9});
}

/// ARKODE multiplies a step that a client chooses by this.
constexpr double kSafetyFactor = 0.5;

SundialsClient& Client(void* client) {
  return *static_cast<SundialsClient*>(client);
}
int Derivatives(double t, N_Vector y, N_Vector ydot, void* client) {
  return Client(client).Derivatives(t, NV_DATA_S(y), NV_DATA_S(ydot));
}
int Roots(double t, N_Vector y, double* g, void* client) {
  return Client(client).Roots(t, NV_DATA_S(y), g);
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
#else
void KeepMessage(int, const char*, const char*, char* message, void* to) {
  *static_cast<std::string*>(to) = message;
}
#endif

}  // namespace

struct SundialsSolver::Handles {
  Handles() { SUNContext_Create(nullptr, &sun); }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    if (table != nullptr) ARKodeButcherTable_Free(table);
    if (linear_solver != nullptr) SUNLinSolFree(linear_solver);
    if (matrix != nullptr) SUNMatDestroy(matrix);
    if (scratch != nullptr) N_VDestroy(scratch);
    N_VDestroy(atol);
    N_VDestroy(y);
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

SundialsSolver::SundialsSolver(const SimulatorOptions& options, double time,
                               const std::vector<double>& absolute_tolerances,
                               const std::vector<int>& directions, SundialsClient& client)
    : api_(Api::Of(options.method)),
      options_(options),
      handles_(std::make_unique<Handles>()),
      directions_(directions) {
  const auto size = static_cast<sunindextype>(absolute_tolerances.size());
  N_Vector& y = handles_->y = N_VNew_Serial(size, handles_->sun);
  N_VEnableFusedOps_Serial(y, SUNTRUE);  // vectors cloned from it inherit them
  if (IsExplicit(options.method)) UseFastOperations(y);
  N_VConst(0, y);
  N_Vector& atol = handles_->atol = N_VNew_Serial(size, handles_->sun);
  std::copy(absolute_tolerances.begin(), absolute_tolerances.end(), N_VGetArrayPointer(atol));
  multistep() ? CreateMultistep(time) : CreateRungeKutta(time, client);
  api_.set_client(memory_, &client);
#if SUNDIALS_VERSION_MAJOR >= 7
  SUNContext_ClearErrHandlers(handles_->sun);
  SUNContext_PushErrHandler(handles_->sun, KeepMessage, &message_);
#else
  const auto set_error_handler = IsExplicit(options.method)        ? ERKStepSetErrHandlerFn
                                 : options.method == Method::kDirk ? ARKStepSetErrHandlerFn
                                                                   : CVodeSetErrHandlerFn;
  set_error_handler(memory_, KeepMessage, &message_);
#endif
  if (IsExplicit(options.method) && options.fixed_step == 0) {
    ERKStepWFtolerances(memory_, ErrorWeights);
  } else {
    api_.set_tolerances(memory_, options.rtol, atol);
  }
  api_.set_max_steps(memory_, options.max_steps);
  if (!directions_.empty()) {
    api_.set_roots(memory_, static_cast<int>(directions_.size()), Roots);
    api_.set_root_directions(memory_, directions_.data());
  }
}

SundialsSolver::~SundialsSolver() {
  if (memory_ != nullptr) api_.free(&memory_);
}

double* SundialsSolver::states() {
  return NV_DATA_S(handles_->y);
}

void SundialsSolver::CreateRungeKutta(double time, SundialsClient& client) {
  Handles& h = *handles_;
  if (IsExplicit(options_.method)) {
    memory_ = ERKStepCreate(Derivatives, time, h.y, h.sun);
    const bool stabilized = options_.method == Method::kStabilized;
    if (options_.order == 2) {
      h.table = stabilized ? StabilizedTable2() : MidpointTable();
    } else if (options_.order == 3) {
      h.table = stabilized ? StabilizedTable3() : RalstonTable();
    }
    if (h.table != nullptr) {
      ERKStepSetTable(memory_, h.table);
    } else {
      ERKStepSetTableNum(memory_, options_.order == 4 ? ARKODE_ZONNEVELD_5_3_4 : ARKODE_DORMAND_PRINCE_7_4_5);
    }
  } else {
    memory_ = ARKStepCreate(nullptr, Derivatives, time, h.y, h.sun);
    ARKStepSetOrder(memory_, options_.order);
    h.matrix = SUNDenseMatrix(N_VGetLength(h.y), N_VGetLength(h.y), h.sun);
    h.linear_solver = SUNLinSol_Dense(h.y, h.matrix, h.sun);
    ARKStepSetLinearSolver(memory_, h.linear_solver, h.matrix);
    // The matrix follows the step size: the default accepts one iteration with a matrix for steps 20 % off,
    // on the strength of how well earlier stages converged, and errs by a hundred tolerances.
    ARKStepSetDeltaGammaMax(memory_, 1e-3);
    if (options_.fixed_step > 0) ARKStepSetMaxNonlinIters(memory_, 10);  // a smaller step is no remedy here
  }
  if (options_.fixed_step > 0) return;
  api_.set_step_chooser(memory_, ChooseStep, &client);
  api_.set_fixed_step_bounds(memory_, 1, 1);
  api_.set_safety_factor(memory_, kSafetyFactor);
  api_.set_error_bias(memory_, 1);
  api_.set_max_growth(memory_, 1e6);
  api_.set_max_first_growth(memory_, 1e6);
}

void SundialsSolver::CreateMultistep(double time) {
  Handles& h = *handles_;
  h.scratch = N_VClone(h.y);
  memory_ = CVodeCreate(options_.method == Method::kBdf ? CV_BDF : CV_ADAMS, h.sun);
  CVodeInit(memory_, Derivatives, time, h.y);
  CVodeSetMaxOrd(memory_, options_.order);
  h.matrix = SUNDenseMatrix(N_VGetLength(h.y), N_VGetLength(h.y), h.sun);
  h.linear_solver = SUNLinSol_Dense(h.y, h.matrix, h.sun);
  CVodeSetLinearSolver(memory_, h.linear_solver, h.matrix);
}

void SundialsSolver::Restart(double time, double end, double step) {
  if (multistep()) {
    earlier_steps_ = steps();
    earlier_failures_ = failed_steps();
  }
  api_.reset(memory_, time, handles_->y);
  if (!std::isinf(end) && !ends_by_steps()) api_.set_stop_time(memory_, end);
  if (multistep()) return;
  options_.fixed_step > 0 ? api_.set_fixed_step(memory_, step) : api_.set_first_step(memory_, step);
}

int SundialsSolver::Evolve(double end, double* time, bool one_step) {
  static_assert(ARK_ONE_STEP == CV_ONE_STEP && ARK_NORMAL == CV_NORMAL);
  if (!ends_by_steps())
    return api_.evolve(memory_, end, handles_->y, time, one_step ? ARK_ONE_STEP : ARK_NORMAL);
  for (long step = 1;; ++step) {
    const int flag = api_.evolve(memory_, end, handles_->y, time, ARK_ONE_STEP);
    if (flag < 0 || one_step || *time >= end - Tiny(end)) return flag;
    if (step == options_.max_steps) {
      message_ = "the interval takes too many steps";
      return kTooMuchWork;
    }
  }
}

void SundialsSolver::SetMaxStep(double step) {
  CVodeSetMaxStep(memory_, std::isinf(step) ? 0 : step);
}

void SundialsSolver::Interpolate(double time, int num_states, double* states) {
  CVodeGetDky(memory_, time, 0, handles_->scratch);
  std::copy_n(NV_DATA_S(handles_->scratch), num_states, states);
}

bool SundialsSolver::IsRoot(int flag) {
  static_assert(ARK_ROOT_RETURN == CV_ROOT_RETURN);
  return flag == ARK_ROOT_RETURN;
}
bool SundialsSolver::IsStopTime(int flag) {
  static_assert(ARK_TSTOP_RETURN == CV_TSTOP_RETURN);
  return flag == ARK_TSTOP_RETURN;
}
bool SundialsSolver::IsErrorTestFailure(int flag) {
  static_assert(ARK_ERR_FAILURE == CV_ERR_FAILURE);
  return flag == ARK_ERR_FAILURE;
}
const int SundialsSolver::kTooMuchWork = ARK_TOO_MUCH_WORK;
bool SundialsSolver::IsTooMuchWork(int flag) {
  static_assert(ARK_TOO_MUCH_WORK == CV_TOO_MUCH_WORK);
  return flag == kTooMuchWork;
}

void SundialsSolver::GetRoots(std::vector<int>* roots) const {
  api_.get_roots(memory_, roots->data());
}

std::vector<double> SundialsSolver::WeightedErrors() const {
  N_Vector errors = N_VClone(handles_->y), weights = N_VClone(handles_->y);
  api_.get_errors(memory_, errors);
  api_.get_weights(memory_, weights);
  std::vector<double> weighted(static_cast<std::size_t>(N_VGetLength(handles_->y)));
  for (std::size_t i = 0; i < weighted.size(); ++i) {
    weighted[i] = std::abs(N_VGetArrayPointer(errors)[i] * N_VGetArrayPointer(weights)[i]);
  }
  N_VDestroy(errors);
  N_VDestroy(weights);
  return weighted;
}

double SundialsSolver::current_time() const {
  double t = 0;
  api_.get_time(memory_, &t);
  return t;
}
double SundialsSolver::current_step() const {
  double h = 0;
  api_.get_current_step(memory_, &h);
  return h;
}
double SundialsSolver::last_step() const {
  double h = 0;
  api_.get_last_step(memory_, &h);
  return h;
}
int SundialsSolver::last_order() const {
  int order = options_.order;
  if (multistep()) CVodeGetLastOrder(memory_, &order);
  return order;
}
long SundialsSolver::steps() const {
  long count = 0;
  api_.get_steps(memory_, &count);
  return earlier_steps_ + count;
}
long SundialsSolver::failed_steps() const {
  long count = 0;
  api_.get_failed_steps(memory_, &count);
  return earlier_failures_ + count;
}

std::string SundialsSolver::Describe(int flag) const {
  char* name = api_.flag_name(flag);
  const std::string text = std::string(name) + ": " + message_;
  std::free(name);
  return text;
}

}  // namespace tenon::internal
