// Random hybrid systems against their exact solutions. A system has one to three independent blocks: balls,
// pucks between walls, relays, clicks, kinks and jumps. Their flows have closed forms, by which the oracle
// computes event after event in long double; it shares no code with the integrator. The systems are scaled in
// state and time, moved, begun late, run by every method, and run again in pieces, with clones and snapshots
// in between.
//
// A run is right if its states and numbers of events agree with the oracle, see Expect. Each system follows
// from its number. To run one again, or many:
//
//     TENON_HYBRID_SYSTEM=1234 build/release/tests/systems_simulation_test --gtest_filter='HybridProperty*'
//     TENON_HYBRID_SYSTEMS=10000 build/release/tests/systems_simulation_test --gtest_filter='HybridProperty*'

#include <tenon/systems/simulation.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cfloat>
#include <numeric>
#include <random>
#include <sstream>

namespace tenon::hybrid_property_test {

using Real = long double;
constexpr Real kInfinity = std::numeric_limits<Real>::infinity();
constexpr Real kEpsilon = DBL_EPSILON;  // of the program under test

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double Uniform(double a, double b) { return a + (b - a) * 0x1p-53 * static_cast<double>(engine_() >> 11); }
  double Log(double a, double b) { return std::exp(Uniform(std::log(a), std::log(b))); }
  bool Chance(double p) { return Uniform(0, 1) < p; }
  int Below(int n) { return static_cast<int>(Uniform(0, n)); }
  double Sign() { return Chance(0.5) ? 1 : -1; }

 private:
  std::mt19937_64 engine_;
};

// ---- The blocks ----

int Increment(const int& n) {
  return n + 1;
}

struct BallParams {
  double x, v, gravity, floor, restitution;
  double rest_below;  ///< speed after an impact at which the ball rests; 0: never
  Crossing crossing;
};
enum class Contact { kFlying, kResting };
struct Ball final : LeafSystem<BallParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x}, v{this, "v", params.v};
  Mode<Contact> mode{this, "contact", Contact::kFlying};
  DiscreteState<int> n{this, "n"};
  TimeDerivative<double> dx{x, Uses(v), [](double v) { return v; }};
  TimeDerivative<double> dv{v, Uses(mode),
                            [this](Contact c) { return c == Contact::kFlying ? -params.gravity : 0.0; }};
  Witness hit{this, "hit", params.crossing, Uses(x), [this](double x) { return x - params.floor; }};
  Update<int> count{n, hit, Uses(n), Increment};
  Update<double> bounce{v, hit, Uses(v), [this](double v) { return Rests(v) ? 0 : -params.restitution * v; }};
  Update<Contact> settle{mode, hit, Uses(v),
                         [this](double v) { return Rests(v) ? Contact::kResting : Contact::kFlying; }};
  bool Rests(double v) const { return v <= 0 && -params.restitution * v < params.rest_below; }
};

struct PuckParams {
  double x, v, drag, low, high, low_restitution, high_restitution;
};
struct Puck final : LeafSystem<PuckParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x}, v{this, "v", params.v};
  DiscreteState<int> n{this, "n"};
  TimeDerivative<double> dx{x, Uses(v), [](double v) { return v; }};
  TimeDerivative<double> dv{v, Uses(v), [this](double v) { return -params.drag * v; }};
  Witness low{this, "low", Crossing::kFalling, Uses(x), [this](double x) { return x - params.low; }};
  Witness high{this, "high", Crossing::kFalling, Uses(x), [this](double x) { return params.high - x; }};
  Update<double> up{v, low, Uses(v), [this](double v) { return -params.low_restitution * v; }};
  Update<double> down{v, high, Uses(v), [this](double v) { return -params.high_restitution * v; }};
  Update<int> count_low{n, low, Uses(n), Increment}, count_high{n, high, Uses(n), Increment};
};

/// x' = slope[mode] + gain (x - center). Mode 0 ends where x rises to the high threshold, mode 1 where it
/// falls to the low one.
struct RelayParams {
  double x, center, gain;
  std::array<double, 2> slope;
  double low, high;
  double moves;  ///< largest change of the thresholds at ticks
  Rate rate = Hz(1);
};
struct RelayFlow : LeafSystem<RelayParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x};
  DiscreteState<int> mode{this, "mode"}, n{this, "n"}, ticks{this, "ticks"};
  TimeDerivative<double> dx{x, Uses(x, mode), [this](double x, int mode) {
                              return params.slope[mode] + params.gain * (x - params.center);
                            }};
  Update<int> count_ticks{ticks, Sampled{params.rate}, Uses(ticks), Increment};
};
/// A fraction in [0, 1) that looks random, of the thresholds at tick `k`.
double Scatter(int k) {
  const double golden = 0.6180339887498949 * (k % 1000 + 1);
  return golden - std::floor(golden);
}
struct Relay final : RelayFlow {
  using RelayFlow::RelayFlow;
  OutputPort<double> move{this, "move", Sampled{params.rate}, Uses(ticks),
                          [this](int k) { return params.moves * Scatter(k); }};
  Witness up{this, "high", Crossing::kRising, Uses(x, move),
             [this](double x, double move) { return x - (params.high + move); }};
  Witness down{this, "low", Crossing::kFalling, Uses(x, move),
               [this](double x, double move) { return x - (params.low + move); }};
  Update<int> off{mode, up, Uses(), [] { return 1; }}, on{mode, down, Uses(), [] { return 0; }};
  Update<int> count_up{n, up, Uses(n), Increment}, count_down{n, down, Uses(n), Increment};
};
/// The relay of a digital controller, which compares at its ticks.
struct SampledRelay final : RelayFlow {
  using RelayFlow::RelayFlow;
  int Decide(double x, int mode) const { return x > params.high ? 1 : x < params.low ? 0 : mode; }
  Update<int> decide{mode, Sampled{params.rate}, Uses(x, mode),
                     [this](double x, int mode) { return Decide(x, mode); }};
  Update<int> count{n, Sampled{params.rate}, Uses(n, x, mode),
                    [this](int n, double x, int mode) { return n + (Decide(x, mode) != mode ? 1 : 0); }};
};

/// x' = f(x) > 0, linear between nodes, with kinks or jumps there; counts the levels that x passes.
struct PassageParams {
  double x, length;
  std::vector<double> nodes, values, gains;  ///< f = values[i] + gains[i] (x - nodes[i]) from node i on
  std::vector<double> levels;
};
/// The number of the last element of `from` that is not above `x`; at least 0.
int Piece(const std::vector<double>& from, double x) {
  return static_cast<int>(
             std::max<std::ptrdiff_t>(1, std::upper_bound(from.begin(), from.end(), x) - from.begin())) -
         1;
}
struct Passage : LeafSystem<PassageParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x};
  DiscreteState<int> n{this, "n"};
  TimeDerivative<double> dx{x, Uses(x), [this](double x) {
                              const int i = Piece(params.nodes, x);
                              return params.values[i] + params.gains[i] * (x - params.nodes[i]);
                            }};
  Witness click{this, "click", Crossing::kRising, Uses(x, n), [this](double x, int n) {
                  return n < static_cast<int>(params.levels.size()) ? x - params.levels[n] : -params.length;
                }};
  Update<int> count{n, click, Uses(n), Increment};
};
struct DeclaredPassage final : Passage {
  using Passage::Passage;
  Kink kink{this, "kink", Uses(x), [this](double x) { return std::int64_t{Piece(params.nodes, x)}; }};
};

/// x'' = u, constant between instants; counts how often x' passes a level.
struct DrivenParams {
  double x, v, level;
  std::vector<double> at, u;  ///< u[i] from at[i] on
};
struct Driven : LeafSystem<DrivenParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x}, v{this, "v", params.v};
  DiscreteState<int> n{this, "n"};
  TimeDerivative<double> dx{x, Uses(v), [](double v) { return v; }};
  TimeDerivative<double> dv{v, Uses(time), [this](double t) { return params.u[Piece(params.at, t)]; }};
  Witness pass{this, "pass", Crossing::kBoth, Uses(v), [this](double v) { return v - params.level; }};
  Update<int> count{n, pass, Uses(n), Increment};
};
struct DeclaredDriven final : Driven {
  using Driven::Driven;
  NextJump jump{this, "jump", Uses(time), [this](double t) {
                  const auto next = std::upper_bound(params.at.begin(), params.at.end(), t);
                  return next == params.at.end() ? kNever : *next;
                }};
};

/// Counts the instants that have passed.
struct AlarmParams {
  std::vector<double> at;
};
struct Alarm final : LeafSystem<AlarmParams> {
  using LeafSystem::LeafSystem;
  DiscreteState<int> n{this, "n"};
  Witness ring{this, "ring", Crossing::kRising, Uses(time, n), [this](double t, int n) {
                 return n < static_cast<int>(params.at.size()) ? t - params.at[n] : -1.0;
               }};
  Update<int> count{n, ring, Uses(n), Increment};
};

// ---- The oracle ----

/// Solution of x' = f + k (x - x0) after `s`: the way from x0.
Real Travel(Real f, Real k, Real s) {
  return k * s == 0 ? f * s : f * std::expm1(k * s) / k;
}
/// The time in which it travels `way`; infinity if never.
Real Reach(Real f, Real k, Real way) {
  const Real straight = way / f, z = k * straight;
  if (way == 0) return 0;
  if (!(straight > 0 && straight < kInfinity) || z <= -1) return kInfinity;
  return z == 0 ? straight : straight * std::log1p(z) / z;
}

struct Motion {
  Real t = 0;  ///< since the beginning of the run
  Real x = 0, v = 0;
  int mode = 0;   ///< or number of the piece
  int n = 0;      ///< events
  int ticks = 1;  ///< including the one at the beginning
};

/// The next event of a motion, after some time.
struct Next {
  Real after = kInfinity;
  int what = 0;
  bool operator<(const Next& other) const { return after < other.after; }
};

/// Scales of a block: a typical length and time, and the origin of its states.
struct Scale {
  double length = 1, time = 1, offset = 0;
  double speed() const { return length / time; }
};

/// A block with its exact solution.
struct Part {
  virtual ~Part() = default;
  virtual void Add(DiagramBuilder& builder) = 0;
  virtual Motion Read(Context& context) const = 0;
  virtual Motion Begin() const = 0;
  /// The time derivatives of x and v.
  virtual std::array<Real, 2> Rates(const Motion& motion) const = 0;
  virtual Next FindNext(const Motion& motion) const = 0;
  virtual void Flow(Motion& motion, Real s) const = 0;
  virtual void Fire(Motion& motion, int what) const = 0;
  /// The time at which events accumulate if the motion has just had one.
  virtual Real Accumulates(const Motion&) const { return kInfinity; }
  /// An upper limit of the time from a flight of this height or speed to the accumulation.
  virtual Real Remains(Real, Real) const { return 0; }

  Scale scale;
  std::string name, family;
  bool polynomial = true;  ///< every explicit method solves the flow exactly
  bool declared = true;    ///< has no kinks and jumps that are not declared
  bool has_speed = false;  ///< v is a state
  bool has_levels =
      false;  ///< the update of a witness moves it to the next level, so two at one instant are one event
  bool ticks = false;
};

/// `Block` is the type with the states; `First` or, if `second` is set, `Second` is added to the diagram.
template <class Params, class Block, class First = Block, class Second = First>
struct PartOf : Part {
  Params p{};
  bool second = false;
  const Block* block = nullptr;
  void Add(DiagramBuilder& builder) override {
    if (second) {
      block = &builder.Add<Second>(name, p);
    } else {
      block = &builder.Add<First>(name, p);
    }
  }
  Motion Read(Context& context) const override {
    Motion motion{.n = context.Eval(block->n)};
    if constexpr (requires { block->x; }) motion.x = context.Eval(block->x);
    if constexpr (requires { block->v; }) motion.v = context.Eval(block->v);
    if constexpr (requires { block->mode; }) motion.mode = static_cast<int>(context.Eval(block->mode));
    if constexpr (requires { block->ticks; }) motion.ticks = context.Eval(block->ticks);
    return motion;
  }
  Motion Begin() const override {
    Motion motion;
    if constexpr (requires { p.x; }) motion.x = p.x;
    if constexpr (requires { p.v; }) motion.v = p.v;
    return motion;
  }
};

struct BallPart : PartOf<BallParams, Ball> {
  std::array<Real, 2> Rates(const Motion& m) const override { return {m.v, m.mode == 0 ? -p.gravity : 0}; }
  Next FindNext(const Motion& m) const override {
    const Real g = p.gravity, height = m.x - p.floor, square = m.v * m.v + 2 * g * height;
    if (m.mode == 1 || square < 0 || (height < 0 && m.v <= 0))
      return {};  // at rest, or errors let it fall through
    return {m.v > 0 ? (m.v + std::sqrt(square)) / g : 2 * height / (std::sqrt(square) - m.v)};
  }
  void Flow(Motion& m, Real s) const override {
    if (m.mode == 1) return;
    m.x += s * (m.v - p.gravity * s / 2);
    m.v -= p.gravity * s;
  }
  void Fire(Motion& m, int) const override {
    ++m.n;
    m.x = p.floor;
    m.v *= -Real{p.restitution};
    if (m.v < p.rest_below) m.v = 0, m.mode = 1;
  }
  Real Accumulates(const Motion& m) const override {
    if (p.restitution == 1 || p.rest_below > 0) return kInfinity;
    return m.t + 2 * m.v / (Real{p.gravity} * (1 - Real{p.restitution}));
  }
  Real Remains(Real height, Real speed) const override {
    return 4 * std::max(std::sqrt(2 * p.gravity * height), speed) / (p.gravity * (1 - p.restitution));
  }
};

struct PuckPart final : PartOf<PuckParams, Puck> {
  std::array<Real, 2> Rates(const Motion& m) const override { return {m.v, -p.drag * m.v}; }
  Next FindNext(const Motion& m) const override {
    return {Reach(m.v, -p.drag, (m.v > 0 ? p.high : p.low) - m.x), m.v > 0};
  }
  void Flow(Motion& m, Real s) const override {
    m.x += Travel(m.v, -p.drag, s);
    m.v *= std::exp(-p.drag * s);
  }
  void Fire(Motion& m, int up) const override {
    ++m.n;
    m.x = up ? p.high : p.low;
    m.v *= -Real{up ? p.high_restitution : p.low_restitution};
  }
};

/// Ticks of one period from the beginning of the run on; `first` is the index of the first one.
struct Ticks {
  std::int64_t numerator = 1, denominator = 1;  ///< of the period [s]
  std::int64_t first = 0;
  double period() const { return static_cast<double>(numerator) / static_cast<double>(denominator); }
  /// A period below a microsecond can only be given as a frequency.
  Rate rate() const {
    return period() < 1e-6 ? Hz(static_cast<double>(denominator / numerator)) : Seconds(period());
  }
  Real At(std::int64_t tick) const { return static_cast<Real>(tick * numerator) / denominator; }
  double start() const { return static_cast<double>(At(first)); }
  /// The time of tick `k` since the beginning of the run.
  Real Time(int k) const { return At(first + k) - start(); }
};

struct RelayPart final : PartOf<RelayParams, RelayFlow, Relay, SampledRelay> {
  Ticks sampling;
  enum { kHigh, kLow, kTick };
  std::array<Real, 2> Rates(const Motion& m) const override {
    return {p.slope[m.mode] + Real{p.gain} * (m.x - p.center), 0};
  }
  Real Moved(int tick) const { return p.moves * Scatter(tick - 1); }
  Next FindNext(const Motion& m) const override {
    const Next tick{std::max(sampling.Time(m.ticks) - m.t, Real{0}), kTick};
    if (second) return tick;
    const Real threshold = (m.mode == 0 ? p.high : p.low) + Moved(m.ticks);
    return std::min(tick, {Reach(Rates(m)[0], p.gain, threshold - m.x), m.mode == 0 ? kHigh : kLow});
  }
  void Flow(Motion& m, Real s) const override { m.x += Travel(Rates(m)[0], p.gain, s); }
  void Fire(Motion& m, int what) const override {
    if (what != kTick) {
      ++m.n;
      m.mode = what == kHigh;
      return;
    }
    const Real before = Moved(m.ticks), after = Moved(++m.ticks);
    if (second) {
      const int mode = m.x > p.high ? 1 : m.x < p.low ? 0 : m.mode;
      m.n += mode != m.mode;
      m.mode = mode;
    } else if (m.x < p.high + before && m.x >= p.high + after) {
      Fire(m, kHigh);
    } else if (m.x > p.low + before && m.x <= p.low + after) {
      Fire(m, kLow);
    }
  }
};

struct PassagePart final : PartOf<PassageParams, Passage, Passage, DeclaredPassage> {
  std::array<Real, 2> Rates(const Motion& m) const override {
    return {p.values[m.mode] + Real{p.gains[m.mode]} * (m.x - p.nodes[m.mode]), 0};
  }
  Next FindNext(const Motion& m) const override {
    const auto reach = [&](const std::vector<double>& all, int i) {
      if (i >= static_cast<int>(all.size())) return kInfinity;
      return Reach(Rates(m)[0], p.gains[m.mode], std::max(Real{0}, all[i] - m.x));
    };
    return std::min(Next{reach(p.levels, m.n), 1}, Next{reach(p.nodes, m.mode + 1), 0});
  }
  void Flow(Motion& m, Real s) const override { m.x += Travel(Rates(m)[0], p.gains[m.mode], s); }
  void Fire(Motion& m, int what) const override { ++(what == 1 ? m.n : m.mode); }
};

struct DrivenPart final : PartOf<DrivenParams, Driven, Driven, DeclaredDriven> {
  double start = 0;
  std::array<Real, 2> Rates(const Motion& m) const override { return {m.v, p.u[m.mode]}; }
  Next FindNext(const Motion& m) const override {
    const auto next = static_cast<std::size_t>(m.mode + 1);
    const Real jump = next < p.at.size() ? std::max(Real{0}, Real{p.at[next]} - start - m.t) : kInfinity;
    const Real way = p.level - m.v;  // 0 after an event
    return std::min(Next{way == 0 ? kInfinity : Reach(p.u[m.mode], 0, way), 1}, Next{jump, 0});
  }
  void Flow(Motion& m, Real s) const override {
    m.x += s * (m.v + p.u[m.mode] * s / 2);
    m.v += p.u[m.mode] * s;
  }
  void Fire(Motion& m, int what) const override {
    if (what == 1) m.v = p.level;
    ++(what == 1 ? m.n : m.mode);
  }
};

struct AlarmPart final : PartOf<AlarmParams, Alarm> {
  double start = 0;
  std::array<Real, 2> Rates(const Motion&) const override { return {0, 0}; }
  Next FindNext(const Motion& m) const override {
    return {m.n < static_cast<int>(p.at.size()) ? std::max(Real{0}, Real{p.at[m.n]} - start - m.t)
                                                : kInfinity};
  }
  void Flow(Motion&, Real) const override {}
  void Fire(Motion& m, int) const override { ++m.n; }
};

/// Errors that are made at the beginning and at each event, and others at the beginning alone: always in one
/// direction or along the motion, so that they add up, or with random signs.
struct Errors {
  Real x = 0, v = 0, first_x = 0, first_v = 0;
  int pattern = 0;
  Random* random = nullptr;
  static constexpr int kPatterns = 10;
  void Make(Motion& m, bool first, bool forwards, bool has_speed) const {
    const auto sign = [&]() -> Real {
      if (pattern > 3) return random->Sign();
      return (pattern % 2 == 0 ? 1 : -1) * (pattern >= 2 && !forwards ? -1 : 1);
    };
    m.x += sign() * (x + (first ? first_x : 0));
    if (has_speed && m.v != 0) m.v += sign() * (v + (first ? first_v : 0));
  }
};

struct Solution {
  Motion end;
  int events = 0;
  Real max_x = 0, max_v = 0, max_dx = 0, max_dv = 0;
  /// The shortest interval between two events, over what the doubles of time and state resolve there.
  Real resolved = kInfinity;
  Real accumulates = kInfinity;  ///< time since the beginning
  Real blurs = kInfinity;  ///< time from which on intervals are shorter than 1e4 times what doubles resolve
};

/// Times are up to `latest`.
Solution Solve(const Part& part, Real duration, Real latest, const Errors& errors = {}) {
  Solution solution;
  Motion m = part.Begin();
  constexpr int kMaxEvents = 1500;
  for (int i = 0;; ++i) {
    if (errors.random != nullptr) errors.Make(m, i == 0, part.Rates(m)[0] >= 0, part.has_speed);
    const auto [dx, dv] = part.Rates(m);
    solution.max_x = std::max(solution.max_x, std::abs(m.x));
    solution.max_v = std::max(solution.max_v, std::abs(m.v));
    solution.max_dx = std::max(solution.max_dx, std::abs(dx));
    solution.max_dv = std::max(solution.max_dv, std::abs(dv));
    const Next next = part.FindNext(m);
    if (!(m.t + next.after <= duration) || i == kMaxEvents) {
      part.Flow(m, duration - m.t);
      break;
    }
    const Real resolved = next.after / (kEpsilon * latest + (dx != 0 ? kEpsilon * std::abs(m.x / dx) : 0));
    if (resolved < 1e4L) solution.blurs = std::min(solution.blurs, m.t);
    solution.resolved = std::min(solution.resolved, resolved);
    part.Flow(m, next.after);
    m.t += next.after;
    part.Fire(m, next.what);
    ++solution.events;
    if (solution.accumulates == kInfinity) solution.accumulates = part.Accumulates(m);
    if (solution.accumulates <= duration && next.after < 1e-12L * solution.accumulates) break;
  }
  solution.end = m;
  return solution;
}

// ---- Systems, and what the oracle expects of them ----

/// The treatment of a run where it is divided: nothing, a clone or a snapshot that goes on in a new simulator
/// or in the same one, a run ahead and back as in predictive control.
enum class Division { kAdvance, kClone, kRestore, kRestoreInNew, kRollout };
struct Cut {
  double time;
  Division division;
  double ahead;   ///< end of a rollout
  int ticks = 0;  ///< that have run at `time`, which is that of a tick; 0: not checked
};

/// Required values of a block at the end of the run.
struct Expected {
  Motion end;
  Real x_error = 0, v_error = 0;                      ///< permitted
  Real resolved = kInfinity;                          ///< see Solution
  Real accumulates = kInfinity, early = 0, late = 0;  ///< time of the accumulation, and interval of the error
};

struct System {
  std::uint64_t number = 0;
  std::vector<std::unique_ptr<Part>> parts;
  SimulatorOptions options;
  double time_scale = 1, start = 0, end = 1;
  std::vector<Cut> cuts;
  std::vector<Expected> expected;
  bool beyond = false;  ///< doubles do not resolve what the problem asks: an error is right, too
  bool decided = true;  ///< permitted errors do not change the number of events
  std::string family() const {
    for (const auto& part : parts) {
      if (part->family != parts[0]->family) return "mixed";
    }
    return parts[0]->family;
  }
  std::string method() const {
    return std::string(NameOf(options.method)) + ' ' + std::to_string(options.order);
  }
  std::string Line() const {
    std::ostringstream os;
    os.precision(3);
    os << "TENON_HYBRID_SYSTEM=" << number << " (" << family() << ", length " << parts[0]->scale.length
       << ", time " << time_scale << ", offset " << parts[0]->scale.offset << ", t0 " << start << ", "
       << method() << ')';
    return os.str();
  }
};

/// Permitted is an error of 20 tolerances, and the effect that errors of this size would have at the
/// beginning and at each event. A multistep method restarts at order 1 at the events of every block, which
/// permits two more tolerances for each. Rounding permits, again there and at the end, 40 units in the last
/// place of the state, of the time (times the rate of the state) and of the scales. An explicit method solves
/// a polynomial flow without an error besides rounding. The problem is beyond doubles if an interval between
/// two events or a step is shorter than 1000 units in the last place of the time, or than the time in which
/// the state changes by as much.
void Expect(System* system, Random& random) {
  const SimulatorOptions& options = system->options;
  const Real duration = Real{system->end} - system->start;
  const Real latest = std::max(std::abs(system->start), std::abs(system->end));
  const bool implicit =
      options.method == Method::kDirk || options.method == Method::kBdf || options.method == Method::kAdams;
  const bool multistep = options.method == Method::kBdf || options.method == Method::kAdams;
  int restarts = 0;
  for (const auto& part : system->parts) restarts += multistep ? Solve(*part, duration, latest).events : 0;
  system->expected.clear();
  system->beyond = options.max_step < 1e3L * kEpsilon * latest;
  system->decided = true;
  for (const auto& part : system->parts) {
    const Solution exact = Solve(*part, duration, latest);
    const Scale& scale = part->scale;
    const auto tolerance = [&](Real largest, Real unit) {
      return 20 * (options.rtol * std::max(largest, unit) + 1e-9L * unit);
    };
    const auto rounding = [&](Real largest, Real unit, Real rate) {
      return 40 * kEpsilon * (largest + unit + rate * (latest + scale.time));
    };
    const Real x_tolerance = tolerance(exact.max_x, scale.length),
               v_tolerance = tolerance(exact.max_v, scale.speed());
    const Real x_rounding = rounding(exact.max_x, scale.length, exact.max_dx);
    const Real v_rounding = rounding(exact.max_v, scale.speed(), exact.max_dv);
    const bool flow_is_exact = !implicit && part->polynomial && part->declared;
    Errors errors{x_rounding + (flow_is_exact ? 0 : x_tolerance),
                  v_rounding + (flow_is_exact ? 0 : v_tolerance),
                  0,
                  0,
                  0,
                  &random};
    const Real beside = multistep ? restarts - exact.events : 0;
    errors.first_x = beside / 10 * x_tolerance;
    errors.first_v = beside / 10 * v_tolerance;
    Expected expected{.end = exact.end, .resolved = exact.resolved, .accumulates = exact.accumulates};
    std::vector<Solution> others;
    for (errors.pattern = 0; errors.pattern < Errors::kPatterns; ++errors.pattern)
      others.push_back(Solve(*part, duration, latest, errors));
    if (exact.accumulates <= duration) {
      // The error may come as soon as flights are too low or too short to be told apart from rest.
      expected.early = std::min(exact.blurs, exact.accumulates * (1 - 1e-6L));
      if (!flow_is_exact) {
        expected.early = std::min(expected.early, exact.accumulates - part->Remains(errors.x, errors.v));
      }
      Real spread = exact.accumulates - expected.early;
      for (const Solution& other : others)
        spread = std::max(spread, 3 * std::abs(other.accumulates - exact.accumulates));
      expected.late = exact.accumulates + spread;
    } else {
      if (exact.resolved < 1000) system->beyond = true;
      for (const Solution& other : others) {
        const Motion &a = other.end, &b = exact.end;
        if (a.n != b.n || a.mode != b.mode || a.ticks != b.ticks) system->decided = false;
        if (other.accumulates <= duration * (1 + 1e-6L)) system->decided = false;
        expected.x_error =
            std::max(expected.x_error, x_rounding + x_tolerance + errors.first_x + std::abs(a.x - b.x));
        expected.v_error =
            std::max(expected.v_error, v_rounding + v_tolerance + errors.first_v + std::abs(a.v - b.v));
      }
    }
    system->expected.push_back(expected);
  }
}

// ---- Random systems ----

constexpr std::pair<Method, int> kIntegrators[] = {
    {Method::kErk, 2},     {Method::kErk, 3},     {Method::kErk, 4},        {Method::kErk, 5},
    {Method::kDirk, 2},    {Method::kDirk, 3},    {Method::kDirk, 4},       {Method::kDirk, 5},
    {Method::kBdf, 5},     {Method::kAdams, 5},   {Method::kStabilized, 2}, {Method::kStabilized, 3},
    {Method::kErkOpen, 2}, {Method::kErkOpen, 3}, {Method::kErkOpen, 4},    {Method::kErkOpen, 5}};

std::unique_ptr<Part> MakeBall(Random& random, const Scale& s) {
  auto part = std::make_unique<BallPart>();
  const int kind = random.Below(3);
  part->family = std::array{"elastic ball", "ball", "ball with rest"}[kind];
  part->has_speed = true;
  part->p = {.x = s.offset + s.length * random.Uniform(0.3, 1.5),
             .v = s.speed() * random.Uniform(-1, 1),
             .gravity = s.speed() / s.time * random.Uniform(1, 10),
             .floor = s.offset,
             .restitution = kind == 0 ? 1 : random.Uniform(0.05, 0.98),
             .rest_below = kind == 2 ? s.speed() * random.Log(1e-6, 0.3) : 0,
             .crossing = random.Chance(0.5) ? Crossing::kFalling : Crossing::kBoth};
  return part;
}

std::unique_ptr<Part> MakePuck(Random& random, const Scale& s) {
  auto part = std::make_unique<PuckPart>();
  part->family = "puck";
  part->has_speed = true;
  part->polynomial = random.Chance(0.5);
  const auto restitution = [&] { return random.Chance(0.5) ? 1 : random.Uniform(0.3, 1); };
  const double width = s.length * random.Uniform(0.3, 2);
  part->p = {.x = s.offset + width * random.Uniform(0.05, 0.95),
             .v = s.speed() * random.Sign() * random.Uniform(0.3, 2),
             .drag = part->polynomial ? 0 : random.Uniform(0.01, 0.5) / s.time,
             .low = s.offset,
             .high = s.offset + width,
             .low_restitution = restitution(),
             .high_restitution = restitution()};
  return part;
}

/// Kind 0 has fixed thresholds, kind 1 sampled thresholds; kind 2 is a digital controller.
std::unique_ptr<Part> MakeRelay(Random& random, const Scale& s, const Ticks& ticks, int kind) {
  auto part = std::make_unique<RelayPart>();
  part->family = std::array{"relay", "relay with sampled thresholds", "sampled relay"}[kind];
  part->ticks = true;
  part->polynomial = random.Chance(0.4);
  part->sampling = ticks;
  part->second = kind == 2;
  const double width = s.length * (kind == 0 ? random.Log(0.02, 0.5) : random.Uniform(0.2, 0.5));
  const double moves = kind == 1 ? s.length * random.Uniform(0.05, 0.4) : 0;
  part->p = {.x = s.offset + moves * Scatter(0) + width * random.Uniform(-0.4, 0.4),
             .center = s.offset,
             .gain = part->polynomial ? 0 : -random.Uniform(0.1, 1) / s.time,
             .slope = {s.speed() * random.Uniform(0.7, 2), -s.speed() * random.Uniform(0.7, 2)},
             .low = s.offset - width / 2,
             .high = s.offset + width / 2,
             .moves = moves,
             .rate = ticks.rate()};
  return part;
}

/// Growing numbers from `first` on, many of them close together, in units of `unit`.
std::vector<double> Growing(Random& random, double first, double unit, int count) {
  std::vector<double> all{first};
  while (static_cast<int>(all.size()) < count) {
    const double next =
        all.back() + unit * (random.Chance(0.6) ? random.Log(1e-9, 1) : random.Uniform(0.1, 2));
    if (next > all.back()) all.push_back(next);
  }
  return all;
}

/// Kind 0 has levels alone, kind 1 kinks, kind 2 jumps. Each undeclared piece lasts a step at least.
std::unique_ptr<Part> MakePassage(Random& random, const Scale& s, double max_step, int kind) {
  auto part = std::make_unique<PassagePart>();
  PassageParams& p = part->p;
  const auto speed = [&] { return s.speed() * random.Log(0.3, 3); };
  part->second = kind > 0 && random.Chance(0.5);
  part->declared = kind == 0 || part->second;
  part->polynomial = kind == 0;
  part->has_levels = true;
  part->family = kind == 0 ? "clicks"
                           : std::string(part->second ? "" : "un") + "declared " +
                                 (kind == 1 ? "kinks" : "jumps in state");
  p = {.x = s.offset - s.length * random.Uniform(0.1, 1),
       .length = s.length,
       .nodes = {s.offset - 10 * s.length},
       .values = {speed()},
       .gains = {0}};
  double node = s.offset, value = p.values[0];
  for (int i = 0; kind > 0 && i < 6; ++i) {
    const double next =
        node + std::max(s.length * random.Log(0.05, 1), part->declared ? 0 : 3.3 * max_step * s.speed());
    if (kind == 2) value = speed();
    p.nodes.push_back(node);
    p.values.push_back(value);
    value = i == 5 ? value : speed();
    p.gains.push_back((value - p.values.back()) / (next - node));
    node = next;
  }
  p.levels = Growing(random, s.offset + s.length * random.Uniform(0, 1), s.length, 1 + random.Below(12));
  return part;
}

std::unique_ptr<Part> MakeDriven(Random& random, const Scale& s, double start, double max_step) {
  auto part = std::make_unique<DrivenPart>();
  part->has_speed = true;
  part->start = start;
  part->second = part->declared = random.Chance(0.5);
  part->family = part->declared ? "declared jumps in time" : "undeclared jumps in time";
  part->p = {
      .x = s.offset, .v = s.speed() * random.Uniform(-1, 1), .level = s.speed() * random.Uniform(-0.5, 0.5)};
  double t = start;
  for (int i = random.Below(8) + 2; i > 0; --i) {
    part->p.at.push_back(t);
    part->p.u.push_back(random.Chance(0.15) ? 0 : random.Sign() * s.speed() / s.time * random.Log(0.1, 3));
    const bool pulse = part->declared && random.Chance(0.5);
    const double next =
        t + (pulse ? s.time * random.Log(1e-7, 1) : std::max(s.time * random.Uniform(0.1, 2), 2 * max_step));
    if (next <= t) break;
    t = next;
  }
  return part;
}

std::unique_ptr<Part> MakeAlarm(Random& random, const Scale& s, double start) {
  auto part = std::make_unique<AlarmPart>();
  part->family = "alarms";
  part->has_levels = true;
  part->start = start;
  part->p.at = Growing(random, start + s.time * random.Uniform(0.1, 2), s.time, 1 + random.Below(12));
  return part;
}

double ScaleFactor(Random& random) {
  return random.Chance(0.3) ? 1 : random.Log(1e-6, 1e6);
}

/// A period of about half the time scale.
Ticks MakeTicks(Random& random, double time_scale) {
  Ticks ticks{.numerator = std::array{1, 2, 5}[random.Below(3)]};
  const int digits = static_cast<int>(std::floor(std::log10(time_scale * 0.5)));
  for (int i = digits; i > 0; --i) ticks.numerator *= 10;
  for (int i = digits; i < 0; ++i) ticks.denominator *= 10;
  return ticks;
}

/// A system, or an unfit one without parts.
System TryToMakeSystem(std::uint64_t number, Random& random) {
  System system{.number = number};
  system.time_scale = ScaleFactor(random);
  Ticks ticks = MakeTicks(random, system.time_scale);
  ticks.first = random.Chance(0.4) ? 0 : std::llround(random.Log(1, 1e9) / ticks.period());
  system.start = ticks.start();
  const auto [method, order] = kIntegrators[number % std::size(kIntegrators)];
  const double max_step = 0.1 * system.time_scale;
  system.options = {.method = method, .order = order, .max_step = max_step};
  const int count = random.Chance(0.6) ? 1 : 2 + random.Below(2);
  const bool mixed = random.Chance(0.5);
  int family = random.Below(10);
  bool polynomial = true, declared = true, ticking = false;
  double offset = 1;  // the largest, in lengths
  for (int i = 0; i < count; ++i) {
    Scale scale{.length = ScaleFactor(random), .time = system.time_scale * random.Uniform(0.5, 2)};
    if (random.Chance(0.5)) scale.offset = random.Sign() * scale.length * random.Log(1, 1e6);
    if (i > 0 && mixed) family = random.Below(10);
    std::unique_ptr<Part> part = family < 2    ? MakeBall(random, scale)
                                 : family == 2 ? MakePuck(random, scale)
                                 : family < 6  ? MakeRelay(random, scale, ticks, family - 3)
                                 : family == 6 ? MakePassage(random, scale, max_step, 0)
                                 : family == 7 ? MakePassage(random, scale, max_step, 1 + random.Below(2))
                                 : family == 8 ? MakeDriven(random, scale, system.start, max_step)
                                               : MakeAlarm(random, scale, system.start);
    part->scale = scale;
    part->name = "b" + std::to_string(i);
    polynomial &= part->polynomial;
    declared &= part->declared;
    ticking |= part->ticks;
    offset = std::max(offset, std::abs(scale.offset) / scale.length);
    if (part->family != "alarms")
      system.options.state_atol.push_back({part->name + ".x", 1e-9 * scale.length});
    if (part->has_speed) system.options.state_atol.push_back({part->name + ".v", 1e-9 * scale.speed()});
    system.parts.push_back(std::move(part));
  }
  // Between ticks kErkOpen and kStabilized do not detect undeclared jumps, nor does kErkOpen of orders 4
  // and 5.
  const bool open = method == Method::kErkOpen || method == Method::kStabilized;
  const bool implicit = method == Method::kDirk || method == Method::kBdf || method == Method::kAdams;
  const bool flow_is_exact = polynomial && !implicit;
  // With smaller tolerances, the errors of methods of order 2 are no longer proportional to them.
  if ((!declared && open && (ticking || order > 3)) || (order == 2 && !flow_is_exact && offset > 10))
    return {};
  // A tolerance relative to the offset would say nothing about the motion.
  system.options.rtol = (method == Method::kDirk && order == 2 ? 1e-4 : 1e-6) / (flow_is_exact ? 1 : offset);
  for (int i = 0; i < 20; ++i) {
    system.end = system.start + system.time_scale * random.Uniform(1, 8);
    Expect(&system, random);
    if (system.decided || system.beyond) break;
  }
  bool fit = system.decided || (system.beyond && random.Chance(0.5));
  for (std::size_t i = 0; i < system.parts.size(); ++i) {
    const Expected& expected = system.expected[i];
    fit &= expected.end.n <= 200 && !(system.parts[i]->has_levels && expected.resolved < 16);
  }
  if (!fit) return {};
  for (int i = 1 + random.Below(4); i > 0; --i) {
    double t = random.Uniform(system.start, system.end);
    const int tick = static_cast<int>((t - system.start) / ticks.period());
    const bool at_tick = ticking && random.Chance(0.3);
    if (at_tick) t = static_cast<double>(ticks.At(ticks.first + tick));
    const double ahead = random.Uniform(t, system.end);
    system.cuts.push_back({t, static_cast<Division>(random.Below(5)), ahead, at_tick ? tick + 1 : 0});
  }
  std::sort(system.cuts.begin(), system.cuts.end(),
            [](const Cut& a, const Cut& b) { return a.time < b.time; });
  return system;
}

System MakeSystem(std::uint64_t number) {
  Random random(number);
  for (;;) {
    System system = TryToMakeSystem(number, random);
    if (!system.parts.empty()) return system;
  }
}

// ---- Runs and their judgement ----

struct RunEnd {
  std::string error;        ///< empty: the run finished
  std::string wrong_ticks;  ///< empty: each tick has run until its time, and no other
  std::vector<Motion> motions;
};

/// Divides the run of `simulator`, which may be replaced.
void Divide(const System& system, const Cut& cut, std::unique_ptr<Simulator>* simulator) {
  Context& context = (*simulator)->context();
  const auto saved = context.Save();
  if (cut.division == Division::kClone) {
    *simulator = std::make_unique<Simulator>(context.Clone(), system.options);
  } else if (cut.division == Division::kRestore) {
    context.Restore(saved);
  } else if (cut.division == Division::kRestoreInNew) {
    auto fresh = context.diagram().CreateContext();
    fresh->Restore(saved);
    *simulator = std::make_unique<Simulator>(std::move(fresh), system.options);
  } else if (cut.division == Division::kRollout) {
    try {
      (*simulator)->RunTo(cut.ahead);
    } catch (const RunError&) {  // judged when the run itself arrives there
    }
    context.Restore(saved);
  }
}

RunEnd Run(const System& system, bool divided) {
  RunEnd end;
  try {
    DiagramBuilder builder;
    for (const auto& part : system.parts) part->Add(builder);
    auto context = builder.Build()->CreateContext();
    context->SetTime(system.start);
    auto simulator = std::make_unique<Simulator>(std::move(context), system.options);
    for (const Cut& cut : divided ? system.cuts : std::vector<Cut>()) {
      simulator->RunTo(cut.time);
      for (const auto& part : system.parts) {
        const int ticks = part->Read(simulator->context()).ticks;
        if (cut.ticks == 0 || !part->ticks || ticks == cut.ticks) continue;
        end.wrong_ticks = fmt::format("{} has run {} instead of {} ticks at t = {}; ", part->name, ticks,
                                      cut.ticks, cut.time);
      }
      Divide(system, cut, &simulator);
    }
    simulator->RunTo(system.end);
    for (const auto& part : system.parts) end.motions.push_back(part->Read(simulator->context()));
  } catch (const std::exception& error) {
    end.error = error.what();
    if (end.error.empty()) end.error = "an exception without a text";
  }
  return end;
}

enum class Verdict { kRight, kRefused, kMute, kUnequal, kEnded, kWrong };
constexpr std::array kVerdicts{
    "right", "refused beyond doubles", "error that names nothing", "depends on division",
    "ended", "silently wrong"};
struct Judgement {
  Verdict verdict = Verdict::kRight;
  std::string text = "";
};

/// An error must name a block and the time. It is right where events accumulate, and then names their
/// witness.
Judgement JudgeError(const System& system, const std::string& error) {
  const auto at = error.find("t = ");
  const Real since =
      at == std::string::npos ? NAN : std::strtod(error.c_str() + at + 4, nullptr) - Real{system.start};
  bool names = false;
  for (std::size_t i = 0; i < system.parts.size(); ++i) {
    const Expected& expected = system.expected[i];
    const std::string& name = system.parts[i]->name;
    const bool due = since >= expected.early && since <= expected.late;
    names |= error.find("'" + name + ".") != std::string::npos;
    if (due && expected.accumulates < kInfinity && error.find("'" + name + ".hit'") != std::string::npos)
      return {};
  }
  return {!names || std::isnan(since) ? Verdict::kMute
          : system.beyond             ? Verdict::kRefused
                                      : Verdict::kEnded,
          error};
}

Judgement Judge(const System& system, const RunEnd& end) {
  if (!end.error.empty()) return JudgeError(system, end.error);
  const Real duration = Real{system.end} - system.start;
  std::string text = end.wrong_ticks;
  for (std::size_t i = 0; i < system.parts.size(); ++i) {
    const Expected& expected = system.expected[i];
    const Motion &is = end.motions[i], &must = expected.end;
    const auto demand = [&](bool holds, const char* what, Real a, Real b, Real error) {
      if (!holds)
        text += fmt::format("{}: {} {:.15g} instead of {:.15g} +- {:.3g}; ", system.parts[i]->name, what, a,
                            b, error);
    };
    if (expected.accumulates < duration)
      return {Verdict::kWrong, system.parts[i]->name + " has passed the accumulation of its events"};
    demand(is.n == must.n, "events", is.n, must.n, 0);
    demand(is.ticks == must.ticks, "ticks", is.ticks, must.ticks, 0);
    demand(std::abs(is.x - must.x) <= expected.x_error, "x", is.x, must.x, expected.x_error);
    demand(std::abs(is.v - must.v) <= expected.v_error, "v", is.v, must.v, expected.v_error);
  }
  return text.empty() || !system.decided ? Judgement() : Judgement{Verdict::kWrong, text};
}

/// Runs a system as a whole and divided; both must be right, and equal bit for bit.
Judgement RunAndJudge(const System& system) {
  const RunEnd whole = Run(system, false), divided = Run(system, true);
  const Judgement first = Judge(system, whole), second = Judge(system, divided);
  if (second.verdict > std::max(first.verdict, Verdict::kUnequal))
    return {second.verdict, "divided: " + second.text};
  if (first.verdict > Verdict::kUnequal || !system.decided) return first;
  std::string text;
  if (whole.error != divided.error) text = "whole: " + whole.error + "; divided: " + divided.error;
  for (std::size_t i = 0; text.empty() && i < whole.motions.size(); ++i) {
    const Motion &a = whole.motions[i], &b = divided.motions[i];
    if (a.x == b.x && a.v == b.v && a.n == b.n && a.mode == b.mode) continue;
    text = fmt::format("{}: whole x {:.17g} v {:.17g}, divided x {:.17g} v {:.17g}", system.parts[i]->name,
                       a.x, a.v, b.x, b.v);
  }
  return text.empty() ? std::max(first, second, [](auto& a, auto& b) { return a.verdict < b.verdict; })
                      : Judgement{Verdict::kUnequal, text};
}

// ---- Tests ----

/// Systems among the first 10,000 whose jumps the error estimate of their method misses.
constexpr std::uint64_t kHard[] = {596,  1997, 3881, 4033, 6217, 6264, 6443, 6737, 6810, 7034, 7105, 7185,
                                   7464, 7682, 7969, 7978, 8436, 8521, 8577, 8653, 9240, 9513, 9940};

TEST(HybridPropertyTest, RandomSystemsAgreeWithTheExactSolution) {
  const auto number = [](const char* name, std::uint64_t otherwise) {
    const char* const text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
  };
  const std::uint64_t one = number("TENON_HYBRID_SYSTEM", 0);
  const std::uint64_t from = one != 0 ? one : 1, to = one != 0 ? one : number("TENON_HYBRID_SYSTEMS", 300);
  std::vector<std::uint64_t> numbers(to - from + 1);
  std::iota(numbers.begin(), numbers.end(), from);
  for (const std::uint64_t hard : kHard) {
    if (one == 0 && hard > to) numbers.push_back(hard);
  }
  std::map<std::string, std::array<int, kVerdicts.size()>> counts;  // by a property of the systems
  for (const std::uint64_t i : numbers) {
    const System system = MakeSystem(i);
    const Judgement judgement = RunAndJudge(system);
    const auto verdict = static_cast<std::size_t>(judgement.verdict);
    if (judgement.verdict > Verdict::kRefused)
      ADD_FAILURE() << kVerdicts[verdict] << ": " << system.Line() << "\n  " << judgement.text;
    const Scale& scale = system.parts[0]->scale;
    const auto decade = [&](const char* name, double value) {
      const double decade = 3 * std::floor(std::log10(std::abs(value)) / 3);
      ++counts[value == 0 ? fmt::format("{} 0", name) : fmt::format("{} from 1e{}", name, decade)][verdict];
    };
    ++counts["all"][verdict];
    ++counts["family: " + system.family()][verdict];
    ++counts["method: " + system.method()][verdict];
    if (system.beyond) ++counts["beyond doubles"][verdict];
    decade("length", scale.length);
    decade("offset", std::abs(scale.offset) / scale.length);
    decade("start", system.start);
    decade("time", system.time_scale);
  }
  fmt::print("{}\n", fmt::join(kVerdicts, ", "));
  for (const auto& [property, row] : counts) fmt::print("{:42}{:6}\n", property, fmt::join(row, ""));
}

/// A ball that lacks its bounce, or bounces when it has fallen 1 % too far.
struct WrongBall : BallPart {
  bool late = false;
  void Add(DiagramBuilder& builder) override {
    BallParams other = p;
    (late ? other.floor : other.restitution) = late ? -0.01 * p.x : -1;
    block = &builder.Add<Ball>(name, other);
  }
};

/// A ball of 1 m above a floor at 0 that is run for 1.4 s, in which it hits the floor twice.
System Bouncing(Method method, std::unique_ptr<BallPart> ball) {
  System system;
  ball->p = {.x = 1,
             .v = 0,
             .gravity = 9.81,
             .floor = 0,
             .restitution = 0.8,
             .rest_below = 0,
             .crossing = Crossing::kFalling};
  ball->name = "ball";
  ball->has_speed = true;
  system.parts.push_back(std::move(ball));
  system.options.method = method;
  system.end = 1.4;
  Random random(1);
  Expect(&system, random);
  return system;
}

TEST(HybridPropertyTest, TheJudgeFindsAWrongBlock) {
  for (const Method method : kAllMethods) {
    EXPECT_EQ(RunAndJudge(Bouncing(method, std::make_unique<BallPart>())).verdict, Verdict::kRight);
    EXPECT_EQ(RunAndJudge(Bouncing(method, std::make_unique<WrongBall>())).verdict, Verdict::kWrong);
    auto late = std::make_unique<WrongBall>();
    late->late = true;
    EXPECT_EQ(RunAndJudge(Bouncing(method, std::move(late))).verdict, Verdict::kWrong);
  }
}

}  // namespace tenon::hybrid_property_test
