#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>
#include <tenon/systems/simulation/internal/step_interpolant.h>
#include <tenon/systems/simulation/internal/sundials_integrator.h>

#include <fmt/core.h>

#include <tuple>

namespace tenon {

namespace {

// Constants of the step-size control, see ChooseStep.
constexpr double kSafety = 0.9;
constexpr double kMaxGrowth = 5;
constexpr double kMinShrink = 0.2;
constexpr double kProportional = 0.7, kIntegral = 0.4;  // exponents of the errors, times the order
/// By order of the estimate: if two successive errors are below this, the second not larger, the step grows
/// by the maximum factor; rounded down from (kSafety / kMaxGrowth)^(order / (kProportional - kIntegral)).
constexpr std::array<double, 6> kNegligible{0, 0, 1e-5, 3.5e-8, 1.1e-10, 0};
constexpr int kMaxRefused = 50;
/// The derivatives jump in an interval if this fraction of their change remains under repeated halving.
constexpr double kStays = 0.2;
/// A jump is suspected where derivatives change faster between two stages than beside them by this factor.
constexpr double kJumps = 3;
/// Error of a step, in tolerances, that a jump must be able to cause to be considered.
constexpr double kShows = 0.1;
/// Error of the step across a jump, in tolerances, at most.
constexpr double kCrosses = 0.01;
/// Error of a step with a kink, over the change of the derivative's rate times the step squared.
constexpr double kKinkWeight = 0.02;
/// First step over the largest one, without further information; the error test corrects it.
constexpr double kFirstTry = 1e-2;
/// After max_steps steps, the movements of this many are averaged.
constexpr double kWatched = 100;

void CheckOptions(const SimulatorOptions& options) {
  const auto demand = [](bool holds, const std::string& text) {
    if (!holds) throw ParameterError("SimulatorOptions: " + text);
  };
  demand(options.method >= Method::kErk && options.method <= Method::kErkOpen,
         fmt::format("Method({}) does not exist", static_cast<int>(options.method)));
  const bool multistep = internal::IsMultistep(options.method);
  const int lowest = multistep ? 1 : 2;
  const int highest = options.method == Method::kAdams ? 12 : options.method == Method::kStabilized ? 3 : 5;
  demand(options.order >= lowest && options.order <= highest,
         fmt::format("order {} does not exist for this method: choose {} to {}", options.order, lowest,
                     highest));
  demand(options.rtol > 0 && options.rtol <= 1,
         fmt::format("`rtol` must be positive and at most 1, but is {}", options.rtol));
  demand(options.atol > 0 && std::isfinite(options.atol),
         fmt::format("`atol` must be positive and finite, but is {}", options.atol));
  for (const StateTolerance& own : options.state_atol) {
    demand(own.atol > 0 && std::isfinite(own.atol),
           fmt::format("`atol` of '{}' must be positive and finite, but is {}", own.prefix, own.atol));
  }

  demand(options.fixed_step >= 0,
         fmt::format("`fixed_step` must not be negative, but is {} s", options.fixed_step));
  demand(options.max_step >= 0,
         fmt::format("`max_step` must not be negative, but is {} s", options.max_step));
  demand(options.fixed_step == 0 || !multistep,
         "fixed_step is for Runge-Kutta methods: CVODE chooses its steps");
}

/// One tolerance per state. A diagram without states but with witnesses gets a dummy state that stays 0.
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
          fmt::format("state_atol: no path of a continuous state begins with '{}'", own.prefix));
    }
  }

  return tolerances;
}

/// Returns whether ticks restart the integrator: open tables are accurate only up to a restart.
bool HasFeedingTicks(const internal::Program& program) {
  return std::ranges::any_of(program.groups, &internal::SampleGroup::feeds);
}

/// Divides the rest of the interval evenly into steps not larger than `wanted`, to avoid a tiny last step.
double EvenStep(double remaining, double wanted) {
  if (remaining <= wanted) return remaining;
  if (std::isinf(remaining)) return wanted;
  const double count = std::ceil(remaining / wanted * (1 - 1e-9));
  return remaining / std::max(1.0, count);
}

}  // namespace

/// Times in it are the solver's: the run's time minus `origin`.
struct SundialsIntegrator::Run final : SundialsIntegrator,
                                       internal::SundialsClient,
                                       internal::DerivativeSource,
                                       internal::EventFinder::Motion {
  Run(Context& c, const SimulatorOptions& o)
      : context(c),
        program(c.diagram().program()),
        options((CheckOptions(o), o)),
        tolerances(AbsoluteTolerances(options, c.diagram())),
        open(HasFeedingTicks(program)),
        solver(options, open, c.time(), tolerances, *this),
        interpolant(program.num_continuous, std::max(3, options.order), options.method == Method::kDirk),
        before(static_cast<std::size_t>(program.num_continuous)),
        step_states(before.size()),
        watched(before.size()),
        checks_stages(options.fixed_step == 0 && (options.method == Method::kDirk ||
                                                  (options.method == Method::kErk && options.order > 3))),
        checks_bends(checks_stages && options.method == Method::kErk && options.order == 5) {
    for (std::vector<double>& each : jump_work) each.resize(tolerances.size());
    for (std::vector<double>& each : motion) each.resize(before.size());
    if (solver.multistep()) slope.resize(before.size()), slope_before.resize(before.size());
    if (checks_stages) stages.slopes.resize(stages.times.size() * before.size());
  }

  bool can_go_on() const override { return live && edition == context.edition_; }
  bool Start(const Interval& next) override {
    if (edition != context.edition_) watches = before_event = false;
    interval = next;
    after_retake = before_event;
    before_event = false;
    if (context.step_start_.valid) return TakeStepAgain();
    SetOrigin(interval.local ? context.time() : 0);
    interval_begin = Local(context.time(), context.time_rest_);
    std::copy_n(context.continuous_data(), program.num_continuous, solver.states());
    Restart(interval_begin, FirstStep(interval_begin));
    return false;
  }

  void Halt() override { live = context.step_start_.valid = false; }
  void Advance(bool one_step) override {
    if (thrown) thrown = nullptr;
    not_finite.clear();
    if (one_step) {
      begin_ = finish_;
      std::copy_n(solver.states(), program.num_continuous, before.data());
      KeepStepStart();
    } else {
      context.step_start_.valid = false;
    }
    bool arrived = false;
    do {
      double t = finish_;
      step_begin = finish_;
      refused = 0;
      if (goes_back) std::copy_n(solver.states(), program.num_continuous, step_states.data());
      if (checks_stages) KeepStage(finish_, nullptr);
      if (solver.multistep()) solver.SetMaxStep(LargestStep(finish_));
      const int flag = solver.Step(Target(), &t);
      if (flag < 0) ThrowFailure(flag);
      if (TakesBack(t)) continue;
      arrived = solver.IsStopTime(flag) || (std::isfinite(end) && t >= end - Tiny(end));
      finish_ = arrived ? end : t;
      if (solver.multistep()) {
        Count(solver.last_step());
      } else if (options.fixed_step > 0) {
        Count(step);
      }
      if (arrived && !before_event) {
        context.num_steps_ = context.movement_ = 0;
      } else {
        CheckProgress(step_begin, finish_);
      }
    } while (!arrived && (!one_step || finish_ == step_begin));
    if (one_step) interpolant.SetStep(begin_, before.data(), finish_, solver.states());
  }

  /// Takes the step from `finish_` to `t` back, for a shorter attempt, if it crosses a jump or a kink of the
  /// derivatives that its error estimate hardly sees. Returns whether it did.
  bool TakesBack(double t) {
    const double bend = checks_ends ? EndBends(t - finish_) : 0;
    if (bend > 1 || (checks_stages && StagesJump())) {
      const auto present = jump;
      if (FindJump(finish_, step_states.data(), finish_, t) && jump.from > finish_ + 4 * Tiny(t)) {
        // another attempt, which ends before the jump
        const auto found = jump;
        Retake(jump.from);
        jump = found;
        jump.step = t - step_begin;
        return true;
      }
      jump = present;
    }
    if (solver.multistep() && SlopesJump(t - finish_)) {
      const bool found = FindJump(finish_, step_states.data(), finish_, t);
      jump.known = false;
      if (found && jump.from > finish_ + 100 * Tiny(t)) {
        EndBefore(jump.from, t - finish_);
        return true;
      }
    }
    const double error = checks_bends ? KinkError() : bend;
    if (error > 1) Retake(finish_ + std::max(kMinShrink, kSafety / std::sqrt(error)) * (t - finish_));
    return error > 1;
  }

  /// Handles a kink, or a witness at which the derivatives jump, inside the last step, which has used
  /// derivatives from both sides. Goes back to end the interval just before, unless the event is at the
  /// beginning of the step. Returns whether it went back.
  bool RetakeBefore(double event) override {
    constexpr double kBefore = 1e-3, kBeginning = 1e-2;
    // A restart of a multistep method costs many small steps, so it comes close to an event only once. Others
    // come closer as long as the states move.
    if (after_retake && (solver.multistep() || !MovesUntil(event))) return false;
    if (event - step_begin <= kBeginning * (finish_ - step_begin)) return false;
    const double size = (1 - kBefore) * (event - step_begin);
    if (size <= 100 * Tiny(event)) return false;
    context.step_start_.valid = false;
    EndBefore(step_begin + size, finish_ - step_begin);
    return true;
  }

  bool ends_before_event() const override { return before_event; }
  double Local(double time, double rest) const override { return time - origin + rest; }
  double rounding(double time) const override { return Tiny(time); }
  double reach() const override { return solver.multistep() ? (Target() - finish_) / 100 : step; }
  void MoveContext(double t) override {
    if (t == end) return MoveContext(t, interval.end, interval.end_rest);
    const double time = Global(t);
    MoveContext(t, time, t - (time - origin));
  }

  void MoveContext(double time, double rest) override { MoveContext(Local(time, rest), time, rest); }
  void EvaluateWitnesses(double t, double* values) override {
    LoadInside(t);
    context.SetRunTime(Instant(t));
    RunWitnesses(values);
  }

  internal::EventFinder::Motion& BeginMotion() override {
    motion_time = context.time();
    motion_begin = Local(motion_time, context.time_rest_);
    std::copy_n(context.continuous_data(), program.num_continuous, motion[0].data());
    has_slope = false;
    return *this;
  }

  void EndMotion() override {
    context.LoadStates(motion[0].data());
    context.SetRunTime(motion_time);
  }

  bool JumpsAt(double event) override {
    std::vector<double>&low = jump_work[0], &high = jump_work[1], &x = jump_work[2];
    const auto derivatives = [&](double t, std::vector<double>& slope) {
      LoadInside(t);
      std::copy_n(context.continuous_data(), x.size(), x.data());
      context.CalcRunDerivatives(Instant(t), x.data(), slope.data());
    };
    const double step = finish_ - begin_, width = 16 * internal::kTimeResolution * std::abs(Global(event));
    derivatives(std::max(begin_, event - width), low);
    derivatives(std::min(finish_, event + width), high);
    MoveContext(event);
    return Change(low.data(), high.data(), x.data()) * step > kShows;
  }

  IntegratorStatistics statistics() const override {
    return {.steps = solver.steps(),
            .failed_steps = solver.failed_steps(),
            .evaluations = evaluations,
            .interpolant_evaluations = interpolant_evaluations,
            .last_step = last_step,
            .smallest_step = smallest_step,
            .largest_step = largest_step,
            .last_order = solver.last_order()};
  }

  void Restart(double time, double first_step) {
    step = first_step;
    restarted = time;
    first_evaluation = true;
    refused = 0;
    failed = false;
    jump.known = false;
    stages.count = 0;
    num_slopes = 0;
    finish_ = time;
    live = true;
    edition = context.edition_;
    interpolant.Restart();
    if (!internal::AllFinite(solver.states(), before.size())) ThrowNonFiniteState(time);
    solver.Restart(time, end, step);
  }

  /// Moves the context to `t`, which is `time` + `rest` of the run.
  /// At the finish, if the last derivatives were evaluated there (true of most Runge-Kutta methods at the end
  /// of an interval), their prerequisites stay fresh for the tick.
  void MoveContext(double t, double time, double rest) {
    context.time_rest_ = rest;
    if (std::abs(t - finish_) <= Tiny(t)) {
      const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(program.num_continuous);
      const bool there = at_end && time == context.time() &&
                         std::memcmp(context.continuous_data(), solver.states(), bytes) == 0;
      if (there) return;
    }
    LoadInside(t);
    context.SetRunTime(time);
  }

  /// Loads the states at `t` in the last step.
  void LoadInside(double t) {
    if (std::abs(t - finish_) <= Tiny(t)) {
      context.LoadStates(solver.states());
    } else if (solver.multistep()) {
      solver.Interpolate(t, program.num_continuous, before.data());
      context.LoadStates(before.data());
    } else {
      interpolant.At(t, *this, before.data());
      context.LoadStates(before.data());
    }
  }

  double FirstStep(double time) {
    const double remaining = end - time;
    if (options.fixed_step > 0) return EvenStep(remaining, options.fixed_step);
    double wanted = context.next_step_;
    if (wanted <= 0) wanted = std::min(remaining, FirstGuess(time));
    return EvenStep(remaining, std::min(wanted, LargestStep(time)));
  }

  /// PI control of the step size (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4
  /// and II, IV.2), with its memory in the context. The rest of the interval is then divided evenly.
  double NextStep(double t, double h, double measured, int order) {
    if (seeks_jumps && (jump.known || measured > 1)) {
      if (const double step = StepRoundJump(t, h, measured <= 1); step > 0) return step;
    }
    // A step shortened by the end of its interval says little about the next one.
    const bool cut = t >= end - Tiny(t) && h < 0.5 * context.next_step_;
    const double error = std::max(measured, 1e-10);
    double factor = kMaxGrowth;
    const bool accepted = measured <= 1;
    if (!accepted && checks_stages) KeepStage(step_begin, nullptr);
    if (accepted) {
      KeepStepControl(h);
      // A small error that has not grown permits the maximum growth without computing powers.
      if (error > kNegligible[static_cast<std::size_t>(order)] || error > context.last_error_) {
        factor = kSafety * std::pow(error, -kProportional / order);
        if (context.last_error_ > 0) factor *= std::pow(context.last_error_, kIntegral / order);
      }
      if (!cut) context.last_error_ = error;
      Count(h);
    } else {
      factor = std::min(kSafety, kSafety * std::pow(error, -1.0 / order));
    }
    double wanted = h * std::clamp(factor, kMinShrink, kMaxGrowth);
    if (accepted && cut) wanted = std::max(wanted, context.next_step_);
    wanted = std::min(wanted, LargestStep(t));
    context.next_step_ = wanted;
    const double remaining = end - t;
    return remaining > Tiny(t) ? EvenStep(remaining, wanted) : wanted;
  }

  /// Keeps the size of an accepted step, and the memory of the step-size control before it, to repeat the
  /// step.
  void KeepStepControl(double h) {
    if (!context.step_start_.valid || has_past()) return;
    context.step_start_.size = h;
    context.step_start_.failed = failed;
    context.step_start_.next_step = context.next_step_;
    context.step_start_.last_error = context.last_error_;
    KeepJump();
  }

  void SetOrigin(double time) {
    origin = time;
    end = last_instant = Local(interval.end, interval.end_rest);
    unit = interval.local ? std::min(1.0, end) : 1;
    if (!interval.jumps) return;
    double before = 8 * internal::Tiny(interval.end);  // blocks compute their jumps with rounding errors
    if (interval.local)
      before = std::min(std::max(4e-15 * std::abs(interval.end), std::min(before, 1e-9 * end)), end);
    last_instant -= before;
  }

  /// A second estimate of the error of a step of `h`, in tolerances, for tables whose own estimate does not
  /// contain the last stage but one: the second difference of the last three stages, which are equidistant.
  /// That stage alone can be beyond a jump in state.
  double EndBends(double h) const {
    double sum = 0;
    for (std::size_t i = 0; i < before.size(); ++i) {
      // Differences of slopes that doubles can hold vanish with h, so a shorter step makes this finite.
      const double change =
          (recent[0][i] - recent[1][i] - (recent[1][i] - recent[2][i])) / Tolerance(step_states.data(), i);
      sum += change * change;
    }
    const double limit = 144 * static_cast<double>(before.size());
    return h * h * sum > limit ? h * std::sqrt(sum / limit) : 0;
  }

  /// Without a limit and an end of the interval by a tick, a step at most doubles the time since the interval
  /// began: a motion that is integrated exactly would otherwise lead to steps too long to separate events.
  double LargestStep(double time) const {
    if (options.max_step > 0) return options.max_step;
    if (std::isinf(end) && time > interval_begin) return time - interval_begin;
    return std::numeric_limits<double>::infinity();
  }

  void Count(double step) {
    last_step = step;
    largest_step = std::max(largest_step, step);
    smallest_step = smallest_step == 0 ? step : std::min(smallest_step, step);
  }

  /// Continues in a context that is inside a step, or at the end of a step that the solver does not know.
  /// Returns whether the step could be repeated.
  bool TakeStepAgain() {
    Context::StepStart& from = context.step_start_;
    const double time = context.time(), rest = context.time_rest_;
    std::copy(from.states.begin(), from.states.end(), solver.states());
    context.next_step_ = from.next_step;
    context.last_error_ = from.last_error;
    interval_begin = from.interval_begin;
    const double num_steps = context.num_steps_;
    before_event = std::isfinite(from.end_before_event);
    SetOrigin(from.origin);
    if (before_event) EndAt(from.end_before_event);
    Restart(from.time, from.size);
    failed = from.failed;
    after_retake = from.after_retake;
    jump = {from.jump_step > 0, from.jump_from, from.jump_to, from.jump_step};
    first_evaluation = false;  // the context's values are for another time
    const std::vector<double> held(context.continuous_data(),
                                   context.continuous_data() + program.num_continuous);
    const double now = Local(time, rest);
    while (finish_ < now - Tiny(now)) Advance(true);
    MoveContext(now, time, rest);
    context.num_steps_ = num_steps;
    watches = false;
    if (std::equal(held.begin(), held.end(), context.continuous_data())) return true;
    // With other options the step would differ, so start from the present states instead.
    from.valid = false;
    context.LoadStates(held.data());
    std::copy(held.begin(), held.end(), solver.states());
    context.SetRunTime(time);
    SetOrigin(interval.local ? time : 0);
    interval_begin = Local(time, rest);
    Restart(interval_begin, FirstStep(interval_begin));
    return false;
  }

  /// Throws RunError if max_steps successive steps have not been as long as they may be, and the states then
  /// move by less than a tolerance per step, or the time by less than its rounding: the length of the steps
  /// is not limited by the accuracy. A tick or a declared jump limits a step, too.
  void CheckProgress(double from, double to) {
    if (before.empty() || options.fixed_step > 0 ||
        (options.max_step > 0 && to - from > 0.5 * options.max_step)) {
      context.num_steps_ = context.movement_ = 0;
      return;
    }
    const auto limit = static_cast<double>(options.max_steps);
    if (++context.num_steps_ < limit) return;
    if (context.num_steps_ == limit || !watches) {
      std::copy_n(solver.states(), before.size(), watched.data());
      watches = true;
      context.num_steps_ = limit;
      context.movement_ = 0;
      return;
    }
    // The way from the beginning of the window: an explicit method at the limit of its stability moves to and
    // fro.
    if (to - from > internal::kTimeResolution * std::abs(Global(to))) {
      context.movement_ =
          std::max(context.movement_, Change(watched.data(), solver.states(), watched.data()));
    }
    if (context.num_steps_ < limit + kWatched) return;
    if (context.movement_ < kWatched) {
      ThrowFailure(
          to, to - from,
          fmt::format("it makes no progress: after {} steps, {} more move the states by {:.2g} tolerances",
                      options.max_steps, kWatched, context.movement_));
    }
    context.num_steps_ = context.movement_ = 0;
  }

  /// A first step without the experience of earlier ones. Without the scale that max_step sets, the
  /// derivatives change the states in it by a part of about sqrt(rtol), so that its error is about a
  /// tolerance.
  double FirstGuess(double time) {
    if (options.max_step > 0) return kFirstTry * options.max_step;
    std::vector<double> slope(before.size());
    context.CalcRunDerivatives(context.time(), solver.states(), slope.data());
    double rate = 0;
    for (std::size_t i = 0; i < slope.size(); ++i)
      rate = std::max(rate, std::sqrt(options.rtol) * std::abs(slope[i]) / Tolerance(solver.states(), i));
    if (rate > 0 && std::isfinite(rate)) return 1 / rate;
    return std::isfinite(end) ? kFirstTry * (end - time) : std::max(1.0, std::abs(context.time()));
  }

  /// The tolerance of the i-th of the states `x`.
  double Tolerance(const double* x, std::size_t i) const {
    return options.rtol * std::abs(x[i]) + tolerances[i];
  }

  /// The largest change from `a` to `b`, in tolerances of the states `x`.
  double Change(const double* a, const double* b, const double* x) const {
    double largest = 0;
    for (std::size_t i = 0; i < before.size(); ++i)
      largest = std::max(largest, std::abs(b[i] - a[i]) / Tolerance(x, i));
    return largest;
  }

  /// Keeps a derivative of the present step. With null, a new attempt begins at `t`; the last derivative of
  /// the step before may be its first.
  void KeepStage(double t, const double* xdot) {
    const std::size_t n = before.size();
    if (xdot == nullptr) {
      std::size_t kept = 0;
      for (std::size_t k = stages.count; k-- > 0 && kept == 0;) {
        if (std::abs(stages.times[k] - t) > Tiny(t)) continue;
        std::copy_n(stages.slopes.data() + k * n, n, stages.slopes.data());
        stages.times[0] = t;
        kept = 1;
      }
      stages.count = kept;
      return;
    }
    if (stages.count > 0 && std::abs(stages.times[stages.count - 1] - t) <= Tiny(t)) --stages.count;
    if (stages.count == stages.times.size()) return;
    stages.times[stages.count] = t;
    std::copy_n(xdot, n, stages.slopes.data() + stages.count * n);
    ++stages.count;
  }

  /// Sorts the stages of the step by time, only the last one at each time, and returns their number.
  std::size_t SortStages(std::array<std::size_t, 16>* sorted) const {
    std::array<std::size_t, 16>& order = *sorted;
    for (std::size_t k = 0; k < stages.count; ++k) order[k] = k;
    std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(stages.count),
              [this](std::size_t a, std::size_t b) {
                return std::pair(stages.times[a], a) < std::pair(stages.times[b], b);
              });
    std::size_t count = 0;
    for (std::size_t k = 0; k < stages.count; ++k) {
      const double time = stages.times[order[k]];
      const bool again = count > 0 && time - stages.times[order[count - 1]] <= Tiny(time);
      order[again ? count - 1 : count++] = order[k];
    }
    return count;
  }

  /// Returns whether the derivatives change much faster between two stages of the step than beside them, in
  /// terms of the error. That is so at a jump, and sometimes without one.
  bool StagesJump() const {
    const std::size_t n = before.size();
    std::array<std::size_t, 16> order{};
    const std::size_t count = SortStages(&order);
    if (count < 3) return false;
    const double h = stages.times[order[count - 1]] - stages.times[order[0]];
    std::array<double, 16> rates{};  // between two stages, for the state that changes fastest
    double largest_change = 0;
    for (std::size_t k = 0; k + 1 < count; ++k) {
      const double* const a = stages.slopes.data() + order[k] * n;
      const double* const b = stages.slopes.data() + order[k + 1] * n;
      const double change = Change(a, b, step_states.data());
      largest_change = std::max(largest_change, change);
      rates[k] = change / (stages.times[order[k + 1]] - stages.times[order[k]]);
    }
    if (largest_change * h < kShows) return false;
    for (std::size_t k = 0; k + 1 < count; ++k) {
      const double beside = std::max(k > 0 ? rates[k - 1] : 0, k + 2 < count ? rates[k + 1] : 0);
      if (rates[k] > kJumps * beside) return true;
    }
    return false;
  }

  /// Estimates the error, in tolerances, of a kink in time inside the step, which the error estimate of the
  /// table hardly sees; 0 unless the derivatives bend much more between two stages than elsewhere. If the
  /// rate of the derivative changes by r at the kink, the error of a step h is a small part of r h^2.
  double KinkError() const {
    const std::size_t n = before.size();
    std::array<std::size_t, 16> order{};
    const std::size_t count = SortStages(&order);
    if (count < 5) return 0;  // fewer than three bends
    const auto time = [&](std::size_t k) { return stages.times[order[k]]; };
    const double h = time(count - 1) - time(0);
    double largest = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto rate = [&](std::size_t k) {
        return (stages.slopes[order[k + 1] * n + i] - stages.slopes[order[k] * n + i]) /
               (time(k + 1) - time(k));
      };
      std::array<double, 16> changes{};  // of the rate from one interval between stages to the next
      for (std::size_t k = 0; k + 2 < count; ++k) changes[k] = rate(k + 1) - rate(k);
      const double tolerance = Tolerance(step_states.data(), i);
      for (std::size_t k = 0; k + 1 < count; ++k) {  // a kink between the stages k and k + 1
        double elsewhere = 0, change = 0;            // largest bend elsewhere, change of the rate here
        for (std::size_t b = 0; b + 2 < count; ++b) {
          if (b + 1 == k || b == k) {
            change += changes[b];
          } else {
            elsewhere = std::max(elsewhere, std::abs(changes[b]) / ((time(b + 2) - time(b)) / 2));
          }
        }
        if (std::abs(change) > kJumps * elsewhere * h)
          largest = std::max(largest, kKinkWeight * std::abs(change) * h * h / tolerance);
      }
    }
    return largest;
  }

  /// Goes back to the beginning of the last step, for a step up to `time`.
  void Retake(double time) {
    std::copy(step_states.begin(), step_states.end(), solver.states());
    context.last_error_ = 0;
    Restart(step_begin, time - step_begin);
    first_evaluation = false;  // the context's values are for another time
  }

  /// Goes back to the beginning of the last step, of size `size`, to end the interval at `time`.
  void EndBefore(double time, double size) {
    EndAt(time);
    before_event = true;
    Retake(end);
    context.next_step_ = size;
  }

  /// Returns whether the derivatives change much faster in the last step, of size `h`, of a multistep method
  /// than in the step before. The method errs by more than it estimates if they jump.
  bool SlopesJump(double h) {
    const double change = Change(slope_before.data(), slope.data(), step_states.data());
    const double last =
        std::exchange(rate, num_slopes < 1 ? std::numeric_limits<double>::infinity() : change / h);
    slope_before = slope;
    return ++num_slopes > 2 && change * h > kShows && rate > kJumps * last;
  }

  /// Returns whether the states move by more than a small part of a tolerance until `event` in the last step.
  bool MovesUntil(double event) {
    LoadInside(event);
    return Change(step_states.data(), context.continuous_data(), step_states.data()) > kCrosses;
  }

  /// Keeps the data needed to repeat the last step. For an explicit Runge-Kutta method that is the step;
  /// methods with hidden history in SUNDIALS (Jacobians, earlier steps) need everything since their start.
  void KeepStepStart() {
    Context::StepStart& from = context.step_start_;
    if (from.valid && has_past()) return;
    from.valid = true;
    from.origin = origin;
    from.time = begin_;
    from.states = before;
    from.size = step;
    from.failed = false;
    from.next_step = context.next_step_;
    from.last_error = context.last_error_;
    from.interval_begin = interval_begin;
    KeepJump();
    from.end_before_event = before_event ? end : std::numeric_limits<double>::infinity();
  }

  /// Ends the interval earlier than it was started for.
  void EndAt(double time) {
    end = last_instant = time;
    interval.end = Global(end);
    interval.end_rest = end - (interval.end - origin);
  }

  /// The run's time.
  double Global(double t) const { return origin + t; }
  /// The time of an evaluation at `t`: not after a jump at the end of the interval.
  double Instant(double t) const { return Global(std::min(t, last_instant)); }
  double Tiny(double t) const { return 1e-14 * (unit + std::abs(t)); }
  void KeepJump() {
    context.step_start_.jump_from = jump.from;
    context.step_start_.jump_to = jump.to;
    context.step_start_.jump_step = jump.known ? jump.step : 0;
    context.step_start_.after_retake = after_retake;
  }

  /// A time that SUNDIALS may take as the end of the integration; CVODE derives its first step from it.
  double Target() const {
    if (std::isfinite(end)) return end;
    const double largest = LargestStep(finish_);
    return finish_ + 1e7 * (std::isfinite(largest) ? largest : step);
  }

  bool has_past() const { return !internal::IsExplicit(options.method); }
  [[noreturn]] void ThrowNonFiniteState(double time) {
    int i = 0;
    while (std::isfinite(solver.states()[i])) ++i;
    throw RunError(fmt::format("state '{}' is {} at t = {} s: set it to a finite value",
                               context.diagram().ContinuousStateNames()[static_cast<std::size_t>(i)],
                               solver.states()[i], Global(time)));
  }

  [[noreturn]] void ThrowFailure(int flag) {
    ++context.instant_;  // the context holds values of different times
    if (thrown) std::rethrow_exception(thrown);
    if (!not_finite.empty()) {
      throw RunError(fmt::format("{}: the run cannot continue; check that block and its inputs", not_finite));
    }
    ThrowFailure(solver.current_time(), solver.current_step(), solver.Describe(flag));
  }

  [[noreturn]] void ThrowFailure(double t, double h, const std::string& what) {
    ++context.instant_;  // the context holds values of different times
    throw RunError(
        fmt::format("the integrator fails at t = {} s with a step of {:.3g} s, `rtol` {:g}: {} [{}]",
                    Global(t), h, options.rtol, DescribeFailure(t, h), what));
  }

  /// Describes the cause, as far as it can be found, the worst state, and the remedy.
  std::string DescribeFailure(double t, double h) {
    const std::string worst_state = "worst state " + DescribeWorstState(h);
    const bool for_smooth = internal::IsExplicit(options.method) || options.method == Method::kAdams;
    try {
      const std::string jump = DescribeJump(t, h);
      if (!jump.empty()) return jump + "; " + worst_state;
      const double rate = FastestRate(t);
      if (for_smooth && std::abs(h) * rate > 0.5) {
        return fmt::format(
            "{}. The system is stiff: its fastest rate there is about {:.2g} /s. Use Method::kBdf or kDirk, "
            "or "
            "loosen the tolerance",
            worst_state, rate);
      }
    } catch (const std::exception&) {
      // The search for the cause evaluates blocks at points outside the run, so their exceptions are ignored.
    }
    if (std::abs(h) <= 100 * Tiny(t)) {
      return worst_state +
             ". The step is within rounding of the time: check the blocks that the derivative depends on. "
             "Loosen the tolerance if they are correct";
    }
    return worst_state + ". Loosen the tolerance" +
           (for_smooth ? ", or use Method::kBdf or kDirk if the system is stiff" : "");
  }

  /// Describes the first block that jumps near `t`; empty if none does.
  std::string DescribeJump(double t, double h) {
    const double reach = 4 * std::max(std::abs(h), 100 * Tiny(t));
    if (!FindJump(t, solver.states(), t - reach, t + reach, 0)) return "";
    const auto& calculations = program.calculations;
    const auto values_at = [&](double time) {
      EvaluateAlong(t, solver.states(), time, jump_work[2].data());
      std::vector<std::vector<double>> values;
      for (const internal::Op& op : program.derivatives.ops)
        values.push_back(context.HeldNumbers(*calculations[op.calculation].source));
      return values;
    };
    const auto is_close = [](double a, double b) {
      return std::abs(b - a) <= 1e-6 * std::max(std::abs(a), std::abs(b));
    };
    const auto below = values_at(jump.from), above = values_at(jump.to);
    std::uint32_t first_jump = UINT32_MAX;  // the first calculation in dataflow order whose value jumps
    for (std::size_t i = 0; i < below.size(); ++i)
      if (!std::ranges::equal(below[i], above[i], is_close))
        first_jump = std::min(first_jump, program.derivatives.ops[i].calculation);
    if (first_jump == UINT32_MAX) return "";
    return fmt::format(
        "'{}' jumps at t = {} s. If it jumps in time, declare a NextJump in that block; if in state, a Kink "
        "or a Witness with a Mode",
        calculations[first_jump].source->path(), Global(jump.to));
  }

  /// Searches for a jump of the derivatives between `from` and `to`, on the straight line through the states
  /// `y` at `t` along the derivatives there, by halving the interval with the largest change. Stores it in
  /// `jump`. Ignores jumps that could not cause an error of `shows` tolerances.
  bool FindJump(double t, const double* y, double from, double to, double shows = kShows) {
    if (before.empty()) return false;
    std::vector<double>&low = jump_work[2], &high = jump_work[3], &middle = jump_work[4];
    context.CalcRunDerivatives(Instant(t), y, jump_work[0].data());
    const auto evaluate = [&](double at, std::vector<double>& f) { EvaluateAlong(t, y, at, f.data()); };
    evaluate(from, low);
    evaluate(to, high);
    const auto change = [&](const std::vector<double>& a, const std::vector<double>& b) {
      return Change(a.data(), b.data(), y);
    };
    const double first = change(low, high);
    // A jump too small for the error test is ignored; it may be rounding.
    jump.known = first * (to - from) > shows;
    while (jump.known && to - from > 8 * Tiny(t)) {
      const double at = from + (to - from) / 2;
      evaluate(at, middle);
      if (change(low, middle) >= change(middle, high)) {
        to = at, high.swap(middle);
      } else {
        from = at, low.swap(middle);
      }
      jump.known = change(low, high) >= kStays * first;
    }
    jump.from = from;
    // The states may need longer than the time to move by their rounding.
    jump.to = shows > 0 ? std::max(to, from + kCrosses / first) : to;
    return jump.known;
  }

  /// Computes the derivatives at time `at`, on the straight line through the states `y` at `t` along the
  /// derivatives there, which FindJump has computed.
  void EvaluateAlong(double t, const double* y, double at, double* xdot) {
    const std::vector<double>& slope = jump_work[0];
    std::vector<double>& x = jump_work[1];
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = y[i] + (at - t) * slope[i];
    context.CalcRunDerivatives(Instant(at), x.data(), xdot);
  }

  /// Handles a jump of the derivatives, in time or state, that is not declared. The error test alone would
  /// approach it in ever smaller steps, and some tables hardly detect it. One step ends just before the jump,
  /// another one crosses it, and then the step size is restored. Returns 0 if there is no such jump.
  double StepRoundJump(double t, double h, bool accepted) {
    if (accepted) KeepStepControl(h);
    if (!jump.known) {
      // After a failed attempt the solver holds its result.
      if (!FindJump(t, accepted ? solver.states() : step_states.data(), t, t + h)) return 0;
      jump.step = h;
    }
    if (accepted) {
      Count(h);
    } else if (t + h <= jump.to + 64 * Tiny(t)) {
      jump.known = false;  // another jump
      return 0;
    }
    double next = jump.from - t;
    if (next <= 4 * Tiny(t)) {
      next = t < jump.to ? jump.to - t + 8 * Tiny(t) : jump.step;
      jump.known = t < jump.to;
    }
    next = std::min(next, end - t);
    if (!(next > 0)) return 0;
    context.next_step_ = next;
    context.last_error_ = 0;
    return next;
  }

  /// A lower bound of the Lipschitz constant of the derivatives [1/s], along the present derivatives.
  double FastestRate(double t) {
    const auto n = static_cast<std::size_t>(program.num_continuous);
    std::vector<double> x(solver.states(), solver.states() + n), f(n), moved(n);
    context.CalcRunDerivatives(Instant(t), x.data(), f.data());
    std::vector<double> direction = f;
    double rate = 0;
    for (int iteration = 0; iteration < 5; ++iteration) {
      double size = 0, norm = 0, difference = 0;
      for (std::size_t i = 0; i < n; ++i) {
        size = std::max(size, std::abs(solver.states()[i]) + tolerances[i]);
        norm = std::max(norm, std::abs(direction[i]));
      }
      if (!(norm > 0)) return rate;
      const double epsilon = 1e-6 * size / norm;
      for (std::size_t i = 0; i < n; ++i) x[i] = solver.states()[i] + epsilon * direction[i];
      context.CalcRunDerivatives(Instant(t), x.data(), moved.data());
      for (std::size_t i = 0; i < n; ++i) {
        direction[i] = moved[i] - f[i];
        difference = std::max(difference, std::abs(direction[i]));
      }
      rate = difference / (epsilon * norm);
    }
    return rate;
  }

  /// The state with the largest error estimate relative to its tolerance; without an estimate, the state that
  /// changes most in a step of `h`.
  std::string DescribeWorstState(double h) {
    if (program.num_continuous == 0) return "none";
    const std::vector<std::string> names = context.diagram().ContinuousStateNames();
    std::size_t worst = 0;
    double largest = 0;
    const auto consider = [&](std::size_t i, double error) {
      if (error > largest) worst = i, largest = error;
    };
    if (options.fixed_step == 0) {
      const std::vector<double> errors = solver.WeightedErrors();
      for (std::size_t i = 0; i < names.size(); ++i) consider(i, errors[i]);
    }
    if (largest > 0) return fmt::format("'{}' (error {:.3g} times its tolerance)", names[worst], largest);
    const double* derivatives = context.derivative_data();
    for (std::size_t i = 0; i < names.size(); ++i)
      consider(i, std::abs(h * derivatives[i]) / Tolerance(context.continuous_data(), i));
    return fmt::format("'{}' (changes by {:.3g} times its tolerance in that step)", names[worst], largest);
  }

  int Derivatives(double t, const double* y, double* ydot) override {
    const int size = program.num_continuous;
    if (size == 0) {
      ydot[0] = 0;
      return 0;
    }
    // Values computed by the tick at the start of an interval are reused, and values computed at its end are
    // kept for the next tick. Sums of steps miss the end by rounding.
    const bool first = first_evaluation && t == restarted;
    first_evaluation = false;
    at_end = !first && last_instant == end && std::abs(t - end) <= Tiny(t);
    if (at_end && !needs_end) {
      at_end = false;
      std::fill_n(ydot, size, 0.0);
      return 0;
    }
    ++evaluations;
    try {
      if (first || at_end) {
        context.LoadStates(y);
        if (at_end) context.SetRunTime(interval.end);
        context.RunStale(program.derivatives);
        context.PackDerivatives();
        std::copy_n(context.derivative_data(), size, ydot);
      } else {
        context.CalcRunDerivatives(Instant(t), y, ydot);
      }
    } catch (...) {
      thrown = std::current_exception();
      return -1;
    }
    if (internal::AllFinite(ydot, before.size())) {
      recent = {recent[1], recent[2], ydot};
      if (checks_stages) KeepStage(t, ydot);
      if (!slope.empty()) std::copy_n(ydot, size, slope.data());
      not_finite.clear();
      return 0;
    }
    not_finite = fmt::format("{} at t = {} s", context.DescribeNonFinite(), Global(t));
    // A smaller step may help; the number of attempts is limited because the step size is not.
    failed = true;
    return first || ++refused > kMaxRefused ? -1 : 1;
  }

  /// Computes the Jacobian by differences with the increments of SUNDIALS. A jump of the derivatives within
  /// an increment would make the matrix so large that Newton's method accepts wrong states. Unless a column
  /// has no effect in the longest step, it is computed on both sides, and a difference that is much smaller
  /// counts.
  int Jacobian(double t, double* y, const double* f, double* const* columns) override {
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon(), kLeast = 1000;
    const std::size_t n = tolerances.size();
    const double step = std::abs(solver.current_step());
    std::vector<double>&weights = jump_work[0], &other = jump_work[1];
    ErrorWeights(y, weights.data());
    const auto norm = [&](const double* from, const double* to) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const double part = (to[i] - (from == nullptr ? 0 : from[i])) * weights[i];
        sum += part * part;
      }
      return std::sqrt(sum / static_cast<double>(n));
    };
    std::copy(slope.begin(), slope.end(), jump_work[2].begin());
    const double size = norm(nullptr, f), longest = std::min(LargestStep(t), end - t);
    const double least = size == 0 ? 1 : kLeast * step * kEpsilon * static_cast<double>(n) * size;
    for (std::size_t j = 0; j < n; ++j) {
      const double state = y[j];
      const double increment = std::max(std::sqrt(kEpsilon) * std::abs(state), least / weights[j]);
      y[j] = state + increment;
      int flag = Derivatives(t, y, columns[j]);
      bool depends = flag == 0 && longest * norm(f, columns[j]) > increment * weights[j];
      if (depends) {
        // The state can be at a bound of the functions' domain, such as the level of an empty tank.
        const auto was = std::tuple(thrown, failed, refused);
        y[j] = state - increment;
        depends = Derivatives(t, y, other.data()) == 0;
        if (!depends) {
          std::tie(thrown, failed, refused) = was;
          not_finite.clear();
        }
      }
      y[j] = state;
      if (flag != 0) {
        std::copy_n(jump_work[2].begin(), slope.size(), slope.begin());
        return flag;
      }
      for (std::size_t i = 0; i < n; ++i) {
        double change = columns[j][i] - f[i];
        if (depends && std::abs(f[i] - other[i]) < 0.5 * std::abs(change)) change = f[i] - other[i];
        columns[j][i] = change / increment;
      }
    }
    std::copy_n(jump_work[2].begin(), slope.size(), slope.begin());
    return 0;
  }

  /// The next step, or the next attempt at a step after an error of more than 1. ARKODE does not lengthen the
  /// step after one with failed attempts; a repeated step has none.
  double ChooseStep(double t, double h, double error, int order) override {
    failed |= error > 1;
    const double next = NextStep(t, h, error, order);
    return error <= 1 && std::exchange(failed, false) ? std::min(next, h) : next;
  }

  void ErrorWeights(const double* y, double* weights) override {
    const double* const absolute = tolerances.data();
    double* const __restrict__ out = weights;
    const double relative = options.rtol;
    for (std::size_t i = 0; i < tolerances.size(); ++i)
      out[i] = 1 / (relative * std::abs(y[i]) + absolute[i]);
  }

  void EvaluateForInterpolant(double t, const double* x, double* xdot) override {
    ++interpolant_evaluations;
    context.CalcRunDerivatives(Instant(t), x, xdot);
    if (internal::AllFinite(xdot, before.size())) return;
    throw RunError(fmt::format(
        "{} at t = {} s, inside an integrator step: the run cannot continue; check that block and its inputs",
        context.DescribeNonFinite(), Global(t)));
  }

  /// The explicit midpoint rule, and the classical Runge-Kutta method of order 3.
  void Evaluate(double ahead, int order, double* values) override {
    const std::vector<double>&x = motion[0], &first = motion[1];
    std::vector<double>&second = motion[2], &third = motion[3], &moved = motion[4];
    const auto derivatives = [&](double t, std::vector<double>& slope) {
      context.CalcRunDerivatives(Instant(t), moved.data(), slope.data());
    };
    for (std::size_t i = 0; i < x.size(); ++i) moved[i] = x[i] + ahead / 2 * first[i];
    derivatives(motion_begin + ahead / 2, second);
    if (order == 2) {
      for (std::size_t i = 0; i < x.size(); ++i) moved[i] = x[i] + ahead * second[i];
    } else {
      for (std::size_t i = 0; i < x.size(); ++i) moved[i] = x[i] + ahead * (2 * second[i] - first[i]);
      derivatives(motion_begin + ahead, third);
      for (std::size_t i = 0; i < x.size(); ++i)
        moved[i] = x[i] + ahead / 6 * (first[i] + 4 * second[i] + third[i]);
    }
    EvaluateWitnessesAt(motion_begin + ahead, moved.data(), values);
  }

  void EvaluateStraight(double ahead, double* values) override {
    if (!has_slope) context.CalcRunDerivatives(motion_time, motion[0].data(), motion[1].data());
    has_slope = true;
    std::vector<double>& moved = motion[4];
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = motion[0][i] + ahead * motion[1][i];
    EvaluateWitnessesAt(motion_begin + ahead, moved.data(), values);
  }

  void EvaluateRounded(double parts, int pattern, double* values) override {
    std::vector<double>& moved = motion[4];
    for (std::size_t i = 0; i < moved.size(); ++i) {
      // Pseudo-random signs: terms that cancel for one pattern do not for another.
      const std::uint64_t hash =
          (i + 1) * (2 * static_cast<std::uint64_t>(pattern) + 1) * 0x9E3779B97F4A7C15u;
      moved[i] = motion[0][i] * (1 + (pattern == 0 || hash >> 63 != 0 ? parts : -parts));
    }
    context.LoadStates(moved.data());
    context.SetRunTime(motion_time * (1 + (pattern % 2 == 0 ? parts : -parts)));
    RunWitnesses(values);
  }

  void EvaluateWitnessesAt(double t, const double* x, double* values) {
    context.LoadStates(x);
    context.SetRunTime(Global(std::min(t, std::max(last_instant, motion_begin))));
    RunWitnesses(values);
  }

  /// Evaluates the witnesses at the present time and states of the context.
  void RunWitnesses(double* values) {
    context.RunAll(program.witnesses);
    ++context.instant_;  // RunAll leaves no stamps
    context.ReadWitnesses(values);
  }

  Context& context;
  const internal::Program& program;
  SimulatorOptions options;
  std::vector<double> tolerances;  // absolute, one per state
  bool open;                       // open tables may be used
  internal::SundialsSolver solver;

  Interval interval;
  double origin = 0;     // the run's time at the solver's time 0 [s]
  double unit = 1;       // 1 s, or the length of a shorter interval in which times are local; see Tiny
  double restarted = 0;  // time of the last restart

  bool live = false;          // the solver is at `finish_` and can continue
  std::uint64_t edition = 0;  // the context's edition that the solver knows
  internal::StepInterpolant interpolant;
  std::vector<double> before;       // states at the beginning of the last Advance
  std::vector<double> step_states;  // states at the beginning of the last step
  std::vector<double> watched;      // states after max_steps steps, see CheckProgress
  bool watches = false;             // these are known
  double step_begin = 0;            // time of the beginning of the last step
  // Open tables meet jumps only at the ticks that end their steps.
  const bool seeks_jumps =
      !(open && (options.method == Method::kErkOpen || options.method == Method::kStabilized));
  // True if accepted steps are searched for jumps that the table detects badly.
  const bool checks_stages;
  const bool checks_bends;  // the stages of DIRK methods are too inaccurate for that
  const bool checks_ends =  // see EndBends
      seeks_jumps && options.fixed_step == 0 && options.order <= 3 &&
      (options.method == Method::kStabilized || (internal::IsExplicit(options.method) && options.order == 3));
  const bool goes_back = seeks_jumps || !program.witness_plans.empty();  // to the beginning of a step
  std::array<const double*, 3> recent{};  // the last three derivatives, in memory of the solver
  // For a multistep method: the last derivatives, those at the end of the step before, the rate at which they
  // changed in it, and the number of steps since the restart.
  std::vector<double> slope, slope_before;
  double rate = 0;
  int num_slopes = 0;
  struct {
    std::size_t count = 0;
    std::array<double, 16> times{};
    std::vector<double> slopes;   // derivatives at those times, contiguous
  } stages;                       // of the present step, the first at its beginning
  double end = 0;                 // of the interval
  bool before_event = false;      // the interval ends just before an event
  bool after_retake = false;      // the interval before did
  double last_instant = 0;        // last instant at which the interval's dynamics may be evaluated
  double interval_begin = 0;      // time of the last Start that did not repeat a step
  double step = 0;                // first step after a restart; with a fixed step, all steps
  int refused = 0;                // non-finite evaluations in the present step
  bool failed = false;            // attempts at the present step failed, so the next one is not longer
  bool first_evaluation = false;  // the next evaluation is the first after the restart
  struct {
    bool known = false;
    double from = 0, to = 0;  // interval that contains it
    double step = 0;          // size of the step that met it
  } jump;
  std::array<std::vector<double>, 5> jump_work;  // of FindJump, JumpsAt and Jacobian
  bool has_slope = false;                        // motion[1] is known
  double motion_begin = 0;                       // of Motion: its time,
  double motion_time = 0;                        // and that in the run's time
  std::array<std::vector<double>, 5> motion;     // states, derivatives there, at two stages, moved states
  bool at_end = false;                           // the last evaluation was at the end of the interval
  // Open tables have no stage at the end of a step. SUNDIALS evaluates there to start the next step, which is
  // unnecessary if a restart comes first.
  const bool needs_end = !open ||
                         (options.method != Method::kErkOpen && options.method != Method::kStabilized) ||
                         options.order > 3;
  std::exception_ptr thrown;
  std::string not_finite;
  long evaluations = 0, interpolant_evaluations = 0;
  double last_step = 0, smallest_step = 0, largest_step = 0;
};

std::unique_ptr<SundialsIntegrator> SundialsIntegrator::Make(Context& context,
                                                             const SimulatorOptions& options) {
  return std::make_unique<Run>(context, options);
}

}  // namespace tenon
