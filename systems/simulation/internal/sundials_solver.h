#pragma once

#include <tenon/systems/simulation/simulator_options.h>

#include <sundials/sundials_nvector.h>

#include <memory>

namespace tenon::internal {

/// True for methods that ERKStep runs.
inline bool IsExplicit(Method method) {
  return method == Method::kErk || method == Method::kErkOpen || method == Method::kStabilized;
}
/// True for methods that CVODE runs.
inline bool IsMultistep(Method method) {
  return method == Method::kBdf || method == Method::kAdams;
}

/// The callbacks of a SundialsSolver.
class SundialsClient {
 public:
  /// Computes `ydot` = f(t, y). Returns 0; a positive number to request a smaller step, a negative one to
  /// fail.
  virtual int Derivatives(double t, const double* y, double* ydot) = 0;
  /// Computes the columns of the Jacobian of f, whose value at (t, y) is `f`; changes `y` meanwhile. Returns
  /// what Derivatives returns. Called by implicit and multistep methods.
  virtual int Jacobian(double t, double* y, const double* f, double* const* columns) = 0;
  /// Returns the step to take at `t`, after a step of size `h` with an error of `error` tolerances; `order`
  /// is the order of the error estimate. Called by Runge-Kutta methods without a fixed step.
  virtual double ChooseStep(double t, double h, double error, int order) = 0;
  /// Computes the error weight of each state in the norm passed to ChooseStep. Called by explicit Runge-Kutta
  /// methods.
  virtual void ErrorWeights(const double* y, double* weights) = 0;

 protected:
  ~SundialsClient() = default;
};

/// ERKStep, ARKStep or CVODE behind one interface. It owns all SUNDIALS handles and checks all calls; only
/// its .cc includes SUNDIALS headers.
///
/// Explicit Runge-Kutta tables, see sundials_solver.cc: pairs of order 2(1), 3(2), 4(3) and 5(4) for
/// Method::kErk, and tables with one stage less for kErkOpen and kStabilized.
class SundialsSolver {
 public:
  /// `absolute_tolerances` has one entry per state. `open` permits tables without a stage at the step's end.
  /// Throws RunError that names the SUNDIALS function if one fails.
  SundialsSolver(const SimulatorOptions& options, bool open, double time,
                 const std::vector<double>& absolute_tolerances, SundialsClient& client);
  ~SundialsSolver();
  SundialsSolver(const SundialsSolver&) = delete;
  SundialsSolver& operator=(const SundialsSolver&) = delete;

  /// The states: set them before Restart, read them after Step.
  double* states() { return states_; }

  /// Starts at `time` with the states in states(), towards `end`, with a first step of `step`. With a fixed
  /// step all steps have this size; CVODE chooses its own.
  void Restart(double time, double end, double step);
  /// Limits the step size of a multistep method; infinity removes the limit.
  void SetMaxStep(double step);
  /// Computes the states at a time within the last step from CVODE's history; only for multistep methods.
  void Interpolate(double time, int num_states, double* states);
  /// Takes one step towards `end`. Returns SUNDIALS's flag, which is negative if the step failed.
  int Step(double end, double* time);

  bool multistep() const { return IsMultistep(options_.method); }
  static bool IsStopTime(int flag);

  /// |local error estimate| times error weight, one per state.
  std::vector<double> WeightedErrors() const;
  double current_time() const;
  double current_step() const;
  double last_step() const;
  int last_order() const;
  long steps() const;
  long failed_steps() const;
  /// The name of `flag` and the last message of SUNDIALS.
  std::string Describe(int flag) const;

 private:
  struct Api;
  struct Handles;
  /// True if the client chooses all steps so that the last one ends with the interval.
  bool ends_by_steps() const { return IsExplicit(options_.method) && options_.fixed_step == 0; }
  void CreateRungeKutta(bool open, double time, SundialsClient& client);
  void CreateMultistep(double time);
  void CreateLinearSolver();
  /// Throws RunError that names `function` if its return value `flag` is negative.
  void Check(int flag, const char* function) const;
  /// The number that a function of SUNDIALS returns by its last argument, checked.
  template <class Number>
  Number Get(int (*get)(void*, Number*), const char* function) const;

  const Api& api_;
  SimulatorOptions options_;
  std::unique_ptr<Handles> handles_;
  double* states_ = nullptr;                       ///< data of SUNDIALS's vector
  void* memory_ = nullptr;                         ///< memory of ERKStep, ARKStep or CVODE
  std::string message_;                            ///< last message of SUNDIALS
  long earlier_steps_ = 0, earlier_failures_ = 0;  ///< before the last CVodeReInit, which resets its counters
};

/// Gives a serial vector and its clones faster operations for explicit Runge-Kutta steps: linear combinations
/// in one pass, copies, and the weighted root-mean-square norm.
///
/// Linear combinations add in SUNDIALS's order. The norm uses eight interleaved partial sums, so that
/// additions do not wait for each other, in the same order on every machine.
void UseFastOperations(N_Vector vector);

}  // namespace tenon::internal
