#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <tenon/systems/simulation/simulator_options.h>

namespace tenon::internal {

/// A rounding error of the time.
inline double Tiny(double time) {
  return 1e-14 * (1 + std::abs(time));
}

/// Whether ERKStep runs it.
inline bool IsExplicit(Method method) {
  return method == Method::kErk || method == Method::kStabilized;
}

/// What SUNDIALS asks of who uses it. The first two return 0, a positive number for "try a smaller step", or
/// a negative one for "give up".
class SundialsClient {
 public:
  virtual int Derivatives(double t, const double* y, double* ydot) = 0;
  virtual int Roots(double t, const double* y, double* g) = 0;
  /// The step to take at `t`, after one of size `h` whose error is `error` tolerances; `order` is that of the
  /// error estimate.
  virtual double ChooseStep(double t, double h, double error, int order) = 0;
  /// What an error of each state counts in the norm that ChooseStep gets; explicit Runge-Kutta methods alone.
  virtual void ErrorWeights(const double* y, double* weights) = 0;

 protected:
  ~SundialsClient() = default;
};

/// ERKStep, ARKStep or CVODE behind one interface: owns every SUNDIALS handle, and knows which function of
/// which of the three does what. No header of SUNDIALS is included anywhere but in its .cc.
///
/// Explicit Runge-Kutta tables, by order: 2 midpoint with Euler embedded, 3 Ralston with one of order 2
/// embedded, 4 Zonneveld, 5 Dormand-Prince; stabilized ones of order 2 and 3.
class SundialsSolver {
 public:
  /// `absolute_tolerances` one per state; `directions` one per root function: +1, -1 or 0 for both.
  SundialsSolver(const SimulatorOptions& options, double time, const std::vector<double>& absolute_tolerances,
                 const std::vector<int>& directions, SundialsClient& client);
  ~SundialsSolver();
  SundialsSolver(const SundialsSolver&) = delete;
  SundialsSolver& operator=(const SundialsSolver&) = delete;

  /// The states: set them before Restart, find them here after Evolve.
  double* states();

  /// Starts again at `time` with what is in states(), towards `end`, with a first step of `step`: with all
  /// steps of that size if the options fix them, while CVODE takes one of its own.
  void Restart(double time, double end, double step);
  /// No step of a multistep method is larger; infinity for no limit.
  void SetMaxStep(double step);
  /// The states at a time within the last step, from CVODE's history; multistep methods alone.
  void Interpolate(double time, int num_states, double* states);
  /// Up to the end of the interval, a root or, if asked, one step on. Returns SUNDIALS's flag.
  int Evolve(double end, double* time, bool one_step);

  bool multistep() const { return options_.method == Method::kBdf || options_.method == Method::kAdams; }
  /// The same in all three solvers.
  static bool IsRoot(int flag);
  static bool IsStopTime(int flag);
  static bool IsErrorTestFailure(int flag);
  static bool IsTooMuchWork(int flag);
  static const int kTooMuchWork;

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

 private:
  struct Api;
  struct Handles;
  /// Its steps, all chosen by the client, end where the interval does: SUNDIALS need not look for that.
  bool ends_by_steps() const {
    return IsExplicit(options_.method) && options_.fixed_step == 0 && directions_.empty();
  }
  void CreateRungeKutta(double time, SundialsClient& client);
  void CreateMultistep(double time);

  const Api& api_;
  SimulatorOptions options_;
  std::unique_ptr<Handles> handles_;
  void* memory_ = nullptr;  ///< of ERKStep, ARKStep or CVODE
  std::vector<int> directions_;
  std::string message_;
  long earlier_steps_ = 0, earlier_failures_ = 0;  // CVodeReInit sets its counters back
};

}  // namespace tenon::internal
