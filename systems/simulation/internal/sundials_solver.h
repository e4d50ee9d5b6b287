#pragma once

#include <cstdio>  // arkode_butcher.h uses FILE without it

#include <arkode/arkode_butcher.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nvector.h>

#include <string>
#include <vector>

#include <tenon/systems/simulation/simulator_options.h>

namespace tenon::internal {

/// What SUNDIALS calls; `client` comes back as the last argument of each.
struct SundialsCallbacks {
  int (*derivatives)(double t, N_Vector y, N_Vector ydot, void* client);
  int (*roots)(double t, N_Vector y, double* g, void* client);
  /// ARKODE's ARKAdaptFn; `next` is the step wanted.
  int (*choose_step)(N_Vector y, double t, double h1, double h2, double h3, double e1, double e2, double e3,
                     int q, int p, double* next, void* client);
  void* client;
};

/// ERKStep, ARKStep or CVODE behind one interface: owns every SUNDIALS handle, and knows which function of
/// which of the three does what. Not part of the public headers: it includes those of SUNDIALS.
///
/// Explicit Runge-Kutta tables, by order: 2 midpoint with Euler embedded, 3 Bogacki-Shampine, 4 Zonneveld,
/// 5 Dormand-Prince.
class SundialsSolver {
 public:
  /// `absolute_tolerances` one per state; `directions` one per root function: +1, -1 or 0 for both.
  SundialsSolver(const SimulatorOptions& options, double time, const std::vector<double>& absolute_tolerances,
                 const std::vector<int>& directions, const SundialsCallbacks& callbacks);
  ~SundialsSolver();
  SundialsSolver(const SundialsSolver&) = delete;
  SundialsSolver& operator=(const SundialsSolver&) = delete;

  /// The states: set them before Restart, find them here after Evolve.
  double* states() { return N_VGetArrayPointer(y_); }
  const double* absolute_tolerances() const { return N_VGetArrayPointer(atol_); }

  /// Starts again at `time` with what is in states(), towards `end`, with a first step of `step`: with all
  /// steps of that size if the options fix them, while CVODE takes one of its own.
  void Restart(double time, double end, double step);
  /// Up to the end of the interval, a root or, if asked, one step on. Returns SUNDIALS's flag.
  int Evolve(double end, double* time, bool one_step);

  bool multistep() const { return options_.method == Method::kBdf || options_.method == Method::kAdams; }
  /// The same in all three solvers.
  static bool IsRoot(int flag);
  static bool IsStopTime(int flag);
  static bool IsErrorTestFailure(int flag);
  static bool IsTooMuchWork(int flag);

  void GetRoots(std::vector<int>* roots) const;
  /// |local error estimate| times error weight, one per state.
  std::vector<double> WeightedErrors() const;
  double current_time() const;
  double current_step() const;
  double last_step() const;
  int last_order() const;
  long steps() const;
  long failed_steps() const;
  /// What `flag` is called, and what SUNDIALS said last.
  std::string Describe(int flag) const;

  /// ARKODE multiplies a step that `choose_step` wants by this.
  static constexpr double kSafetyFactor = 0.5;

 private:
  struct Api;
  void CreateRungeKutta(double time, const SundialsCallbacks& callbacks);
  void CreateMultistep(double time, const SundialsCallbacks& callbacks);

  const Api& api_;
  SimulatorOptions options_;
  SUNContext sun_ = nullptr;
  N_Vector y_ = nullptr;
  N_Vector atol_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver linear_solver_ = nullptr;
  ARKodeButcherTable table_ = nullptr;
  void* memory_ = nullptr;
  std::vector<int> directions_;
  std::string message_;
  long earlier_steps_ = 0, earlier_failures_ = 0;  // CVodeReInit sets its counters back
};

}  // namespace tenon::internal
