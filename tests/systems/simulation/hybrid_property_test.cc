// Random hybrid systems against their exact solutions. Each system has one to three independent blocks:
// balls, pucks between walls, relays, clicks, kinks and jumps. Their flows have closed forms, in which the
// oracle computes event after event in long double; it shares no code with the integrator. The systems are
// scaled in state and time, moved, begun late, run by every method, and run again in pieces, with clones and
// snapshots.
//
// A system is judged right if its states and numbers of events agree with the oracle, see Expect. Each system
// follows from its number. To run one again, or many:
//
//     TENON_HYBRID_SYSTEM=1234 build/release/tests/systems_simulation_test --gtest_filter='HybridProperty*'
//     TENON_HYBRID_SYSTEMS=10000 build/release/tests/systems_simulation_test --gtest_filter='HybridProperty*'

#include <tenon/systems/simulation.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <gtest/gtest.h>

#include <array>
#include <cfloat>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <sstream>
#include <string>
#include <vector>

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

struct BallParams {
  double x, v, gravity, floor, restitution;
  double rest_below;  ///< speed after an impact at which the ball rests; 0: never
  Crossing crossing;
};
enum class Contact { kFlying, kResting };
struct Ball final : LeafSystem<BallParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x}, v{this, "v", params.v};
  Mode<Contact> contact{this, "contact", Contact::kFlying};
  DiscreteState<int> n{this, "n"};
  TimeDerivative<double> dx{x, Uses(v), [](double v) { return v; }};
  TimeDerivative<double> dv{v, Uses(contact),
                            [this](Contact c) { return c == Contact::kFlying ? -params.gravity : 0.0; }};
  Witness hit{this, "hit", params.crossing, Uses(x), [this](double x) { return x - params.floor; }};
  Update<int> count{n, hit, Uses(n), [](int n) { return n + 1; }};
  Update<double> bounce{v, hit, Uses(v), [this](double v) { return Rests(v) ? 0 : -params.restitution * v; }};
  Update<Contact> settle{contact, hit, Uses(v),
                         [this](double v) { return Rests(v) ? Contact::kResting : Contact::kFlying; }};
  bool Rests(double v) const { return -params.restitution * v < params.rest_below; }
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
  Update<int> count_low{n, low, Uses(n), [](int n) { return n + 1; }};
  Update<int> count_high{n, high, Uses(n), [](int n) { return n + 1; }};
};

/// A fraction in [0, 1) that looks random, for the thresholds at tick `k`.
double Scatter(int k) {
  const double golden = 0.6180339887498949 * (k % 1000 + 1);
  return golden - std::floor(golden);
}

/// x' = slope[mode] + gain (x - center). Mode 0 ends where x rises to the high threshold, mode 1 where it
/// falls to the low one. With `moves`, both thresholds are sampled and move at ticks.
struct RelayParams {
  double x, center, gain;
  std::array<double, 2> slope;
  double low, high, moves;
  Rate rate = Hz(1);
};
struct Relay final : LeafSystem<RelayParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x};
  DiscreteState<int> mode{this, "mode"}, n{this, "n"}, tick{this, "tick"};
  Update<int> next_tick{tick, Sampled{params.rate}, Uses(tick), [](int k) { return k + 1; }};
  OutputPort<double> move{this, "move", Sampled{params.rate}, Uses(tick),
                          [this](int k) { return params.moves * Scatter(k); }};
  TimeDerivative<double> dx{x, Uses(x, mode), [this](double x, int mode) {
                              return params.slope[mode] + params.gain * (x - params.center);
                            }};
  Witness high{this, "high", Crossing::kRising, Uses(x, move),
               [this](double x, double move) { return x - (params.high + move); }};
  Witness low{this, "low", Crossing::kFalling, Uses(x, move),
              [this](double x, double move) { return x - (params.low + move); }};
  Update<int> off{mode, high, Uses(), [] { return 1; }};
  Update<int> on{mode, low, Uses(), [] { return 0; }};
  Update<int> count_high{n, high, Uses(n), [](int n) { return n + 1; }};
  Update<int> count_low{n, low, Uses(n), [](int n) { return n + 1; }};
};

/// The relay of a digital controller, which compares at its ticks.
struct SampledRelay final : LeafSystem<RelayParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x};
  DiscreteState<int> mode{this, "mode"}, n{this, "n"}, tick{this, "tick"};
  Update<int> next_tick{tick, Sampled{params.rate}, Uses(tick), [](int k) { return k + 1; }};
  TimeDerivative<double> dx{x, Uses(x, mode), [this](double x, int mode) {
                              return params.slope[mode] + params.gain * (x - params.center);
                            }};
  Update<int> decide{mode, Sampled{params.rate}, Uses(x, mode), &SampledRelay::Decide};
  Update<int> count{n, Sampled{params.rate}, Uses(n, x, mode),
                    [this](int n, double x, int mode) { return n + (Decide(x, mode) != mode ? 1 : 0); }};
  int Decide(double x, int mode) const { return x > params.high ? 1 : x < params.low ? 0 : mode; }
};

/// x' = f(x) > 0, linear between nodes, with kinks or jumps there; counts the levels that x passes.
struct PassageParams {
  double x;
  std::vector<double> nodes, values, gains;  ///< f = values[i] + gains[i] (x - nodes[i]) from node i on
  std::vector<double> levels;
  double length;
  int Piece(double x) const {
    int i = 0;
    while (i + 1 < static_cast<int>(nodes.size()) && x >= nodes[i + 1]) ++i;
    return i;
  }
};
struct Passage : LeafSystem<PassageParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x};
  DiscreteState<int> n{this, "n"};
  TimeDerivative<double> dx{x, Uses(x), [this](double x) {
                              const int i = params.Piece(x);
                              return params.values[i] + params.gains[i] * (x - params.nodes[i]);
                            }};
  Witness click{this, "click", Crossing::kRising, Uses(x, n), [this](double x, int n) {
                  return n < static_cast<int>(params.levels.size()) ? x - params.levels[n] : -params.length;
                }};
  Update<int> count{n, click, Uses(n), [](int n) { return n + 1; }};
};
struct DeclaredPassage final : Passage {
  using Passage::Passage;
  Kink kink{this, "kink", Uses(x), [this](double x) { return std::int64_t{params.Piece(x)}; }};
};

/// x'' = u, constant between instants; counts how often x' passes a level.
struct DrivenParams {
  double x, v;
  std::vector<double> at, u;  ///< u[i] from at[i] on
  double level;
  int Piece(double t) const {
    int i = 0;
    while (i + 1 < static_cast<int>(at.size()) && t >= at[i + 1]) ++i;
    return i;
  }
};
struct Driven : LeafSystem<DrivenParams> {
  using LeafSystem::LeafSystem;
  ContinuousState<double> x{this, "x", params.x}, v{this, "v", params.v};
  DiscreteState<int> n{this, "n"};
  TimeDerivative<double> dx{x, Uses(v), [](double v) { return v; }};
  TimeDerivative<double> dv{v, Uses(time), [this](double t) { return params.u[params.Piece(t)]; }};
  Witness pass{this, "pass", Crossing::kBoth, Uses(v), [this](double v) { return v - params.level; }};
  Update<int> count{n, pass, Uses(n), [](int n) { return n + 1; }};
};
struct DeclaredDriven final : Driven {
  using Driven::Driven;
  NextJump jump{this, "jump", Uses(time), [this](double t) {
                  const auto next = static_cast<std::size_t>(params.Piece(t)) + 1;
                  return next < params.at.size() ? params.at[next] : kNever;
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
  Update<int> count{n, ring, Uses(n), [](int n) { return n + 1; }};
};

// ---- The oracle ----

/// Solution of x' = f + k (x - x0) after `s`: the way from x0. Accurate for all k s.
Real Travel(Real f, Real k, Real s) {
  return k * s == 0 ? f * s : f * std::expm1(k * s) / k;
}
/// The time in which it travels `way`; infinity if never.
Real Reach(Real f, Real k, Real way) {
  if (way == 0) return 0;
  if (way / f <= 0 || !std::isfinite(way / f)) return kInfinity;
  const Real z = k * way / f;
  return z <= -1 ? kInfinity : z == 0 ? way / f : way / f * std::log1p(z) / z;
}

struct Motion {
  Real t = 0;  ///< since the beginning of the run
  Real x = 0, v = 0;
  int mode = 0;
  int n = 0;      ///< events
  int ticks = 1;  ///< including the one at the beginning
};

/// What happens next in a motion, after some time.
struct Next {
  Real after = kInfinity;
  int what = 0;
};

/// Scales of a block: a typical length and time, and the origin of its states.
struct Scale {
  double length = 1, time = 1, offset = 0;
  double speed() const { return length / time; }
};

/// A block with its exact solution.
class Part {
 public:
  virtual ~Part() = default;
  virtual std::string family() const = 0;
  virtual void Add(DiagramBuilder& builder, const std::string& name) = 0;
  virtual Motion Read(Context& context) const = 0;
  virtual Motion Begin() const = 0;
  /// The time derivatives of x and v.
  virtual std::array<Real, 2> Rates(const Motion& motion) const = 0;
  virtual Next FindNext(const Motion& motion) const = 0;
  virtual void Flow(Motion& motion, Real s) const = 0;
  virtual void Fire(Motion& motion, int what) const = 0;
  /// The time at which events accumulate if the motion has just had one.
  virtual Real Accumulates(const Motion&) const { return kInfinity; }
  virtual bool polynomial() const { return true; }  ///< every one-step method solves it exactly
  virtual bool declared() const { return true; }
  virtual bool has_speed() const { return false; }  ///< v is a state
  /// The update of a witness moves it to the next level. Two levels at one instant are one event.
  virtual bool has_levels() const { return false; }
  virtual bool ticks() const { return false; }
  virtual std::string witness() const { return ""; }
  virtual void Describe(std::ostream&) const {}

  Scale scale;
  std::string name;
};

struct BallPart : Part {
  BallParams p;
  const Ball* block = nullptr;
  std::string family() const override {
    return p.rest_below > 0 ? "ball with rest" : p.restitution == 1 ? "elastic ball" : "ball";
  }
  void Add(DiagramBuilder& builder, const std::string& name) override { block = &builder.Add<Ball>(name, p); }
  Motion Read(Context& c) const override {
    return {.x = c.Eval(block->x),
            .v = c.Eval(block->v),
            .mode = static_cast<int>(c.Eval(block->contact)),
            .n = c.Eval(block->n)};
  }
  Motion Begin() const override { return {.x = p.x, .v = p.v}; }
  std::array<Real, 2> Rates(const Motion& m) const override { return {m.v, m.mode == 0 ? -p.gravity : 0}; }
  Next FindNext(const Motion& m) const override {
    if (m.mode == 1) return {};
    const Real g = p.gravity, height = m.x - p.floor, square = m.v * m.v + 2 * g * height;
    if (square < 0 || (height < 0 && m.v <= 0)) return {};  // fell through, which only errors can do
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
    return m.mode == 1 || p.restitution == 1 || p.rest_below > 0
               ? kInfinity
               : m.t + 2 * m.v / (Real{p.gravity} * (1 - Real{p.restitution}));
  }
  bool has_speed() const override { return true; }
  std::string witness() const override { return "hit"; }
  void Describe(std::ostream& os) const override {
    os << "x " << p.x << " v " << p.v << " g " << p.gravity << " floor " << p.floor << " e " << p.restitution
       << " rest_below " << p.rest_below << (p.crossing == Crossing::kBoth ? " kBoth" : " kFalling");
  }
};

struct PuckPart final : Part {
  PuckParams p;
  const Puck* block = nullptr;
  std::string family() const override { return "puck"; }
  void Add(DiagramBuilder& builder, const std::string& name) override { block = &builder.Add<Puck>(name, p); }
  Motion Read(Context& c) const override {
    return {.x = c.Eval(block->x), .v = c.Eval(block->v), .n = c.Eval(block->n)};
  }
  Motion Begin() const override { return {.x = p.x, .v = p.v}; }
  std::array<Real, 2> Rates(const Motion& m) const override { return {m.v, -p.drag * m.v}; }
  Next FindNext(const Motion& m) const override {
    const bool up = m.v > 0;
    return {Reach(m.v, -p.drag, up ? p.high - m.x : p.low - m.x), up};
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
  bool polynomial() const override { return p.drag == 0; }
  bool has_speed() const override { return true; }
  void Describe(std::ostream& os) const override {
    os << "x " << p.x << " v " << p.v << " drag " << p.drag << " walls " << p.low << ' ' << p.high << " e "
       << p.low_restitution << ' ' << p.high_restitution;
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
  double start() const { return static_cast<double>(static_cast<Real>(first * numerator) / denominator); }
  /// The time of tick `k` since the beginning of the run.
  Real Time(int k) const { return static_cast<Real>((first + k) * numerator) / denominator - start(); }
};

struct RelayPart final : Part {
  RelayParams p;
  bool at_ticks = false;  ///< a SampledRelay
  Ticks sampling;
  const Relay* relay = nullptr;
  const SampledRelay* sampled = nullptr;
  enum { kHigh, kLow, kTick };
  std::string family() const override {
    return at_ticks ? "sampled relay" : p.moves != 0 ? "relay, sampled thresholds" : "relay";
  }
  void Add(DiagramBuilder& builder, const std::string& name) override {
    if (at_ticks) {
      sampled = &builder.Add<SampledRelay>(name, p);
    } else {
      relay = &builder.Add<Relay>(name, p);
    }
  }
  Motion Read(Context& c) const override {
    if (at_ticks) {
      return {.x = c.Eval(sampled->x),
              .mode = c.Eval(sampled->mode),
              .n = c.Eval(sampled->n),
              .ticks = c.Eval(sampled->tick)};
    }
    return {.x = c.Eval(relay->x),
            .mode = c.Eval(relay->mode),
            .n = c.Eval(relay->n),
            .ticks = c.Eval(relay->tick)};
  }
  Motion Begin() const override { return {.x = p.x}; }  // between the thresholds at the tick of the beginning
  std::array<Real, 2> Rates(const Motion& m) const override {
    return {p.slope[m.mode] + Real{p.gain} * (m.x - p.center), 0};
  }
  Real Move(const Motion& m, int tick) const {
    return m.ticks + tick < 0 ? 0 : p.moves * Scatter(m.ticks - 1 + tick);
  }
  Next FindNext(const Motion& m) const override {
    const Next tick{std::max(sampling.Time(m.ticks) - m.t, Real{0}), kTick};
    if (at_ticks) return tick;
    const Real f = Rates(m)[0], move = Move(m, 0);
    const Next cross{Reach(f, p.gain, (m.mode == 0 ? p.high : p.low) + move - m.x),
                     m.mode == 0 ? kHigh : kLow};
    return cross.after <= tick.after ? cross : tick;
  }
  void Flow(Motion& m, Real s) const override { m.x += Travel(Rates(m)[0], p.gain, s); }
  void Fire(Motion& m, int what) const override {
    if (what == kTick) {
      const Real before = Move(m, 0);
      ++m.ticks;
      const Real after = Move(m, 0);
      if (at_ticks) {
        const int mode = m.x > p.high ? 1 : m.x < p.low ? 0 : m.mode;
        m.n += mode != m.mode;
        m.mode = mode;
      } else if (m.x < p.high + before && m.x >= p.high + after) {
        Fire(m, kHigh);
      } else if (m.x > p.low + before && m.x <= p.low + after) {
        Fire(m, kLow);
      }
      return;
    }
    ++m.n;
    m.mode = what == kHigh;
  }
  bool polynomial() const override { return p.gain == 0; }
  bool ticks() const override { return true; }
  void Describe(std::ostream& os) const override {
    os << "x " << p.x << " center " << p.center << " gain " << p.gain << " slopes " << p.slope[0] << ' '
       << p.slope[1] << " low " << p.low << " high " << p.high << " moves " << p.moves << " period "
       << sampling.period();
  }
};

struct PassagePart : Part {
  PassageParams p;
  bool is_declared = false, jumps = false;
  const Passage* block = nullptr;
  std::string family() const override {
    return p.nodes.size() == 1 ? "clicks"
                               : std::string(is_declared ? "declared " : "undeclared ") +
                                     (jumps ? "jumps in state" : "kinks");
  }
  void Add(DiagramBuilder& builder, const std::string& name) override {
    if (is_declared) {
      block = &builder.Add<DeclaredPassage>(name, p);
    } else {
      block = &builder.Add<Passage>(name, p);
    }
  }
  Motion Read(Context& c) const override { return {.x = c.Eval(block->x), .n = c.Eval(block->n)}; }
  Motion Begin() const override { return {.x = p.x}; }  // in piece 0, which is the mode
  std::array<Real, 2> Rates(const Motion& m) const override {
    return {p.values[m.mode] + Real{p.gains[m.mode]} * (m.x - p.nodes[m.mode]), 0};
  }
  Next FindNext(const Motion& m) const override {
    const auto reach = [&](Real x) {
      return std::max(Real{0}, x <= m.x ? 0 : Reach(Rates(m)[0], p.gains[m.mode], x - m.x));
    };
    const Next node{m.mode + 1 < static_cast<int>(p.nodes.size()) ? reach(p.nodes[m.mode + 1]) : kInfinity,
                    0};
    const Next click{m.n < static_cast<int>(p.levels.size()) ? reach(p.levels[m.n]) : kInfinity, 1};
    return click.after <= node.after ? click : node;
  }
  void Flow(Motion& m, Real s) const override { m.x += Travel(Rates(m)[0], p.gains[m.mode], s); }
  void Fire(Motion& m, int what) const override { ++(what == 1 ? m.n : m.mode); }
  bool polynomial() const override {
    for (const double gain : p.gains)
      if (gain != 0) return false;
    return true;
  }
  bool declared() const override { return is_declared || p.nodes.size() == 1; }
  bool has_levels() const override { return true; }
  void Describe(std::ostream& os) const override {
    os << "x " << p.x << " nodes";
    for (std::size_t i = 0; i < p.nodes.size(); ++i)
      os << ' ' << p.nodes[i] << ':' << p.values[i] << ',' << p.gains[i];
    os << " levels";
    for (const double level : p.levels) os << ' ' << level;
  }
};

struct DrivenPart final : Part {
  DrivenParams p;
  double start = 0;
  bool is_declared = false;
  const Driven* block = nullptr;
  std::string family() const override {
    return is_declared ? "declared jumps in time" : "undeclared jumps in time";
  }
  void Add(DiagramBuilder& builder, const std::string& name) override {
    if (is_declared) {
      block = &builder.Add<DeclaredDriven>(name, p);
    } else {
      block = &builder.Add<Driven>(name, p);
    }
  }
  Motion Read(Context& c) const override {
    return {.x = c.Eval(block->x), .v = c.Eval(block->v), .n = c.Eval(block->n)};
  }
  Motion Begin() const override { return {.x = p.x, .v = p.v}; }
  std::array<Real, 2> Rates(const Motion& m) const override { return {m.v, p.u[m.mode]}; }
  Next FindNext(const Motion& m) const override {
    const Next jump{m.mode + 1 < static_cast<int>(p.at.size())
                        ? std::max(Real{0}, Real{p.at[m.mode + 1]} - start - m.t)
                        : kInfinity,
                    0};
    // After an event v is at the level.
    const Real away = m.v - p.level;
    const Next pass{away == 0 ? kInfinity : Reach(p.u[m.mode], 0, -away), 1};
    return pass.after <= jump.after ? pass : jump;
  }
  void Flow(Motion& m, Real s) const override {
    m.x += s * (m.v + p.u[m.mode] * s / 2);
    m.v += p.u[m.mode] * s;
  }
  void Fire(Motion& m, int what) const override {
    if (what == 0) {
      ++m.mode;
    } else {
      ++m.n;
      m.v = p.level;
    }
  }
  bool declared() const override { return is_declared; }
  bool has_speed() const override { return true; }
  void Describe(std::ostream& os) const override {
    os << "x " << p.x << " v " << p.v << " level " << p.level << " u";
    for (std::size_t i = 0; i < p.at.size(); ++i) os << ' ' << p.at[i] << ':' << p.u[i];
  }
};

struct AlarmPart final : Part {
  AlarmParams p;
  double start = 0;
  const Alarm* block = nullptr;
  std::string family() const override { return "alarms"; }
  void Add(DiagramBuilder& builder, const std::string& name) override {
    block = &builder.Add<Alarm>(name, p);
  }
  Motion Read(Context& c) const override { return {.n = c.Eval(block->n)}; }
  Motion Begin() const override { return {}; }
  std::array<Real, 2> Rates(const Motion&) const override { return {0, 0}; }
  Next FindNext(const Motion& m) const override {
    return {m.n < static_cast<int>(p.at.size()) ? std::max(Real{0}, Real{p.at[m.n]} - start - m.t)
                                                : kInfinity};
  }
  void Flow(Motion&, Real) const override {}
  bool has_levels() const override { return true; }
  void Fire(Motion& m, int) const override { ++m.n; }
  void Describe(std::ostream& os) const override {
    for (const double at : p.at) os << ' ' << at;
  }
};

/// Errors that are made at the beginning and at each event: with random signs, or always in one direction or
/// along the motion, so that they add up.
struct Errors {
  Real x = 0, v = 0;
  int pattern = 0;
  Random* random = nullptr;
  static constexpr int kPatterns = 10;
  void Make(Motion& m, Real dx, bool has_speed) const {
    const Real way = dx < 0 ? -1 : 1;
    const auto sign = [&]() -> Real {
      return pattern == 0 ? 1 : pattern == 1 ? -1 : pattern == 2 ? way : pattern == 3 ? -way : random->Sign();
    };
    m.x += sign() * x;
    if (has_speed && m.v != 0) m.v += sign() * v;
  }
};

struct Solution {
  Motion end;
  Real max_x = 0, max_v = 0, max_dx = 0, max_dv = 0;
  /// The shortest interval between two events, over what the doubles of time and state resolve there.
  Real resolved = kInfinity;
  Real accumulates = kInfinity;  ///< time since the beginning
  Real blurs = kInfinity;        ///< time of the event from which on they are too close to be told apart
};

Solution Solve(const Part& part, Real duration, Real latest, Errors errors = {}) {
  Solution solution;
  Motion m = part.Begin();
  constexpr int kMaxEvents = 1500;
  for (int i = 0;; ++i) {
    if (errors.random != nullptr) errors.Make(m, part.Rates(m)[0], part.has_speed());
    const auto [dx, dv] = part.Rates(m);
    solution.max_x = std::max(solution.max_x, std::abs(m.x));
    solution.max_v = std::max(solution.max_v, std::abs(m.v));
    solution.max_dx = std::max(solution.max_dx, std::abs(dx));
    solution.max_dv = std::max(solution.max_dv, std::abs(dv));
    const Next next = part.FindNext(m);
    const Real resolution = kEpsilon * latest + (dx != 0 ? kEpsilon * std::abs(m.x / dx) : 0);
    if (!(m.t + next.after <= duration) || i == kMaxEvents) {
      part.Flow(m, duration - m.t);
      break;
    }
    if (next.after < 1e4L * resolution) solution.blurs = std::min(solution.blurs, m.t);
    solution.resolved = std::min(solution.resolved, next.after / resolution);
    part.Flow(m, next.after);
    m.t += next.after;
    part.Fire(m, next.what);
    if (i == 0 || solution.accumulates == kInfinity) solution.accumulates = part.Accumulates(m);
    if (solution.accumulates <= duration && next.after < 1e-12L * solution.accumulates) break;
  }
  solution.end = m;
  return solution;
}

// ---- Random systems ----

struct Integrator {
  Method method;
  int order;
};
constexpr Integrator kIntegrators[] = {
    {Method::kErk, 2},     {Method::kErk, 3},     {Method::kErk, 4},        {Method::kErk, 5},
    {Method::kDirk, 2},    {Method::kDirk, 3},    {Method::kDirk, 4},       {Method::kDirk, 5},
    {Method::kBdf, 5},     {Method::kAdams, 5},   {Method::kStabilized, 2}, {Method::kStabilized, 3},
    {Method::kErkOpen, 2}, {Method::kErkOpen, 3}, {Method::kErkOpen, 4},    {Method::kErkOpen, 5}};

/// What happens to a run where it is divided.
enum class Division { kAdvance, kClone, kRestore, kRestoreInNew, kRollout };
struct Cut {
  double time;
  Division division;
  double ahead;   ///< end of a rollout
  int ticks = 0;  ///< that have run at `time`, which is that of a tick; 0: not checked
};

/// What the oracle expects of one block at the end of the run.
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
  bool decided = true;  ///< small errors do not change the number of events
  Real resolved = kInfinity;
  std::string family() const {
    for (const auto& part : parts)
      if (part->family() != parts[0]->family()) return "mixed";
    return parts[0]->family();
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
  void Describe(std::ostream& os) const {
    os.precision(17);
    os << Line() << "\n  start " << start << " end " << end << " rtol " << options.rtol << " atol "
       << options.atol << " max_step " << options.max_step << " beyond " << beyond << " decided " << decided
       << " resolved " << static_cast<double>(resolved) << '\n';
    for (const StateTolerance& own : options.state_atol)
      os << "  atol " << own.prefix << ' ' << own.atol << '\n';
    for (const Cut& cut : cuts)
      os << "  cut " << cut.time << ' ' << static_cast<int>(cut.division) << ' ' << cut.ahead << ' ' << cut.ticks << '\n';
    for (std::size_t i = 0; i < parts.size(); ++i) {
      os << "  " << parts[i]->name << ' ' << parts[i]->family() << ": ";
      parts[i]->Describe(os);
      const Expected& e = expected[i];
      os << "\n    expected x " << e.end.x << " +- " << e.x_error << " v " << e.end.v << " +- " << e.v_error
         << " events " << e.end.n << " accumulates " << start + e.accumulates << " in " << start + e.early
         << " to " << start + e.late << '\n';
    }
  }
};

std::unique_ptr<Part> MakeBall(Random& random, const Scale& s, double) {
  auto part = std::make_unique<BallPart>();
  const double gravity = s.length / (s.time * s.time) * random.Uniform(1, 10);
  const int kind = random.Below(3);
  part->p = {.x = s.offset + s.length * random.Uniform(0.3, 1.5),
             .v = s.speed() * random.Uniform(-1, 1),
             .gravity = gravity,
             .floor = s.offset,
             .restitution = kind == 0 ? 1 : random.Uniform(0.05, 0.98),
             .rest_below = kind == 2 ? s.speed() * random.Log(1e-6, 0.3) : 0,
             .crossing = random.Chance(0.5) ? Crossing::kFalling : Crossing::kBoth};
  return part;
}

std::unique_ptr<Part> MakePuck(Random& random, const Scale& s, double) {
  auto part = std::make_unique<PuckPart>();
  const auto restitution = [&] { return random.Chance(0.5) ? 1 : random.Uniform(0.3, 1); };
  const double width = s.length * random.Uniform(0.3, 2);
  part->p = {.x = s.offset + width * random.Uniform(0.05, 0.95),
             .v = s.speed() * random.Sign() * random.Uniform(0.3, 2),
             .drag = random.Chance(0.5) ? 0 : random.Uniform(0.01, 0.5) / s.time,
             .low = s.offset,
             .high = s.offset + width,
             .low_restitution = restitution(),
             .high_restitution = restitution()};
  return part;
}

std::unique_ptr<Part> MakeRelay(Random& random, const Scale& s, const Ticks& ticks, int kind) {
  auto part = std::make_unique<RelayPart>();
  part->sampling = ticks;
  part->at_ticks = kind == 2;
  const double width = s.length * (kind == 0 ? random.Log(0.02, 0.5) : random.Uniform(0.2, 0.5));
  const double low = s.offset - width / 2, high = s.offset + width / 2;
  const double moves = kind == 1 ? s.length * random.Uniform(0.05, 0.4) : 0;
  part->p = {.x = low + moves * Scatter(0) + (high - low) * random.Uniform(0.1, 0.9),
             .center = s.offset,
             .gain = random.Chance(0.4) ? 0 : -random.Uniform(0.1, 1) / s.time,
             .slope = {s.speed() * random.Uniform(0.7, 2), -s.speed() * random.Uniform(0.7, 2)},
             .low = low,
             .high = high,
             .moves = moves,
             .rate = ticks.rate()};
  return part;
}

std::unique_ptr<Part> MakePassage(Random& random, const Scale& s, double max_step, int kind) {
  auto part = std::make_unique<PassagePart>();
  PassageParams& p = part->p;
  p.length = s.length;
  p.x = s.offset - s.length * random.Uniform(0.1, 1);
  p.nodes = {s.offset - 10 * s.length};
  p.values = {s.speed() * random.Log(0.3, 3)};
  p.gains = {0};
  part->is_declared = kind > 0 && random.Chance(0.5);
  part->jumps = kind == 2;
  double node = s.offset;
  for (int i = 0; kind > 0 && i < 6; ++i) {
    // Each undeclared piece lasts a step at least.
    const double width =
        std::max(s.length * random.Log(0.05, 1), part->is_declared ? 0 : 3.3 * max_step * s.speed());
    const double begin = part->jumps ? s.speed() * random.Log(0.3, 3)
                         : i == 0    ? p.values[0]
                                     : p.values[i] + p.gains[i] * (node - p.nodes[i]);
    const double value = s.speed() * random.Log(0.3, 3);
    p.nodes.push_back(node);
    p.values.push_back(begin);
    const double next = node + width;
    p.gains.push_back(i == 5 ? 0 : (value - begin) / (next - node));
    node = next;
  }
  double level = s.offset + s.length * random.Uniform(0, 1);
  for (int i = random.Below(12) + (kind == 0); i > 0; --i) {
    p.levels.push_back(level);
    const double next =
        level + s.length * (random.Chance(0.6) ? random.Log(1e-9, 1) : random.Uniform(0.1, 2));
    if (next <= level) break;
    level = next;
  }
  return part;
}

std::unique_ptr<Part> MakeDriven(Random& random, const Scale& s, double start, double max_step) {
  auto part = std::make_unique<DrivenPart>();
  part->start = start;
  part->is_declared = random.Chance(0.5);
  DrivenParams& p = part->p;
  p.x = s.offset;
  p.v = s.speed() * random.Uniform(-1, 1);
  p.level = s.speed() * random.Uniform(-0.5, 0.5);
  double t = start;
  for (int i = random.Below(8) + 2; i > 0; --i) {
    p.at.push_back(t);
    const double acceleration = s.speed() / s.time * random.Log(0.1, 3);
    p.u.push_back(random.Chance(0.15)              ? 0
                  : p.v + 0 * t > 0 && p.u.empty() ? -acceleration
                                                   : random.Sign() * acceleration);
    const double next = t + (part->is_declared && random.Chance(0.5)
                                 ? s.time * random.Log(1e-7, 1)
                                 : std::max(s.time * random.Uniform(0.1, 2), 2 * max_step));
    if (next <= t) break;
    t = next;
  }
  return part;
}

std::unique_ptr<Part> MakeAlarm(Random& random, const Scale& s, double start) {
  auto part = std::make_unique<AlarmPart>();
  part->start = start;
  double t = start + s.time * random.Uniform(0.1, 2);
  for (int i = random.Below(12) + 1; i > 0; --i) {
    part->p.at.push_back(t);
    const double next = t + s.time * (random.Chance(0.6) ? random.Log(1e-9, 1) : random.Uniform(0.1, 2));
    if (next <= t) break;
    t = next;
  }
  return part;
}

/// A power of ten between 1e-6 and 1e6, or often 1.
double ScaleFactor(Random& random) {
  return random.Chance(0.3) ? 1 : random.Log(1e-6, 1e6);
}

/// Computes what the run must end with. Permitted is an error of 20 tolerances, and the effect that errors of
/// this size would have at the beginning and at each event. Rounding permits, again there and at the end, 40
/// units in the last place of the state, of the time (times the rate of the state), and of the time scale. An
/// explicit method solves a polynomial flow without an error besides rounding.
void Expect(System* system, Random& random) {
  const SimulatorOptions& options = system->options;
  const Real duration = Real{system->end} - system->start;
  const Real latest = std::max(std::abs(system->start), std::abs(system->end));
  const bool explicit_method = options.method == Method::kErk || options.method == Method::kErkOpen ||
                               options.method == Method::kStabilized;
  system->expected.clear();
  system->beyond = options.max_step < 1e3L * kEpsilon * latest;
  system->decided = true;
  system->resolved = options.max_step / (kEpsilon * latest);
  for (const auto& part : system->parts) {
    const Solution exact = Solve(*part, duration, latest);
    const bool blind = options.method == Method::kDirk && options.order == 5 && !part->declared();
    const Real tolerances = blind ? 300 : 20;
    const Scale& scale = part->scale;
    const Real x_tolerance =
        tolerances * (options.rtol * std::max<Real>(exact.max_x, scale.length) + 1e-9L * scale.length);
    const Real v_tolerance =
        tolerances * (options.rtol * std::max<Real>(exact.max_v, scale.speed()) + 1e-9L * scale.speed());
    const Real time = latest + scale.time;
    const Real x_rounding = 40 * kEpsilon * (exact.max_x + scale.length + exact.max_dx * time);
    const Real v_rounding = 40 * kEpsilon * (exact.max_v + scale.speed() + exact.max_dv * time);
    const bool flow_is_exact = explicit_method && part->polynomial() && part->declared();
    Errors errors{x_rounding + (flow_is_exact ? 0 : x_tolerance),
                  v_rounding + (flow_is_exact ? 0 : v_tolerance), 0, &random};
    Expected expected{.end = exact.end,
                      .x_error = x_rounding + x_tolerance,
                      .v_error = v_rounding + v_tolerance,
                      .accumulates = exact.accumulates};
    if (exact.accumulates <= duration) {
      // The error may come as soon as flights are too low or too short to be told apart from rest.
      expected.early = std::min(exact.blurs, exact.accumulates * (1 - 1e-6L));
      expected.late = exact.accumulates + (exact.accumulates - expected.early);
      for (errors.pattern = 0; errors.pattern < Errors::kPatterns; ++errors.pattern) {
        const Solution other = Solve(*part, duration, latest, errors);
        expected.late =
            std::max(expected.late, other.accumulates + 2 * std::abs(other.accumulates - exact.accumulates));
        if (!flow_is_exact) {
          // The height or speed of a flight within its errors.
          const auto* ball = dynamic_cast<const BallPart*>(part.get());
          const Real speed = std::max(std::sqrt(2 * ball->p.gravity * errors.x), errors.v);
          expected.early = std::min(
              expected.early, exact.accumulates - 4 * speed / (ball->p.gravity * (1 - ball->p.restitution)));
          expected.late = std::max(expected.late, 2 * exact.accumulates - expected.early);
        }
      }
    } else {
      expected.resolved = exact.resolved;
      system->resolved = std::min(system->resolved, exact.resolved);
      if (exact.resolved < 1000) system->beyond = true;
      for (errors.pattern = 0; errors.pattern < Errors::kPatterns; ++errors.pattern) {
        const Solution other = Solve(*part, duration, latest, errors);
        if (other.end.n != exact.end.n || other.end.mode != exact.end.mode ||
            other.end.ticks != exact.end.ticks)
          system->decided = false;
        if (other.accumulates <= duration * (1 + 1e-6L)) system->decided = false;
        expected.x_error =
            std::max(expected.x_error, x_rounding + x_tolerance + std::abs(other.end.x - exact.end.x));
        expected.v_error =
            std::max(expected.v_error, v_rounding + v_tolerance + std::abs(other.end.v - exact.end.v));
      }
    }
    system->expected.push_back(expected);
  }
}

System MakeSystem(std::uint64_t number) {
  Random random(number);
  for (;;) {
    System system;
    system.number = number;
    system.time_scale = ScaleFactor(random);
    system.start = random.Chance(0.4) ? 0 : random.Log(1, 1e9);
    Ticks ticks;
    const int digits = static_cast<int>(std::floor(std::log10(system.time_scale * 0.5)));
    ticks.numerator = std::array{1, 2, 5}[random.Below(3)];
    for (int i = digits; i > 0; --i) ticks.numerator *= 10;
    for (int i = digits; i < 0; ++i) ticks.denominator *= 10;
    ticks.first = std::llround(system.start / ticks.period());
    system.start = ticks.start();

    const auto [method, order] = kIntegrators[number % std::size(kIntegrators)];
    const double max_step = 0.1 * system.time_scale;
    system.options = {.method = method, .order = order, .max_step = max_step};
    const int count = random.Chance(0.6) ? 1 : 2 + random.Below(2);
    const bool mixed = random.Chance(0.5);
    int family = random.Below(10);
    bool polynomial = true, ticking = false;
    double offset = 1;  // the largest, in lengths
    for (int i = 0; i < count; ++i) {
      Scale scale{.length = ScaleFactor(random), .time = system.time_scale * random.Uniform(0.5, 2)};
      if (random.Chance(0.5)) scale.offset = random.Sign() * scale.length * random.Log(1, 1e6);
      if (i > 0 && mixed) family = random.Below(10);
      std::unique_ptr<Part> part;
      switch (family) {
        case 0:
        case 1:
          part = MakeBall(random, scale, 0);
          break;
        case 2:
          part = MakePuck(random, scale, 0);
          break;
        case 3:
        case 4:
        case 5:
          part = MakeRelay(random, scale, ticks, family - 3);
          break;
        case 6:
          part = MakePassage(random, scale, max_step, 0);
          break;
        case 7:
          part = MakePassage(random, scale, max_step, 1 + random.Below(2));
          break;
        case 8:
          part = MakeDriven(random, scale, system.start, max_step);
          break;
        default:
          part = MakeAlarm(random, scale, system.start);
      }
      part->scale = scale;
      part->name = "b" + std::to_string(i);
      polynomial &= part->polynomial();
      ticking |= family >= 3 && family <= 5;
      offset = std::max(offset, std::abs(scale.offset) / scale.length);
      system.options.state_atol.push_back({part->name + ".x", 1e-9 * scale.length});
      system.options.state_atol.push_back({part->name + ".v", 1e-9 * scale.speed()});
      system.parts.push_back(std::move(part));
    }
    // Between ticks kErkOpen and kStabilized do not detect undeclared jumps, nor does kErkOpen of orders 4
    // and 5.
    const bool open = method == Method::kErkOpen || method == Method::kStabilized;
    const bool sees_jumps = !open || (!ticking && order < 4);
    bool blind = false;
    for (const auto& part : system.parts) blind |= !part->declared() && !sees_jumps;
    if (blind) continue;
    std::erase_if(system.options.state_atol, [&](const StateTolerance& own) {
      const Part& part = *system.parts[static_cast<std::size_t>(own.prefix[1] - '0')];
      return part.family() == "alarms" || (!part.has_speed() && own.prefix.ends_with("v"));
    });
    const bool multistage = method == Method::kDirk || method == Method::kBdf || method == Method::kAdams;
    const bool flow_is_exact = polynomial && !multistage;
    // With smaller tolerances, the errors of methods of order 2 are no longer proportional to them.
    if (order == 2 && !flow_is_exact && offset > 10) continue;
    system.options.rtol =
        (method == Method::kDirk && order == 2 ? 1e-4 : 1e-6) / (flow_is_exact ? 1 : offset);
    for (int i = 0; i < 20; ++i) {
      system.end = system.start + system.time_scale * random.Uniform(1, 8);
      Expect(&system, random);
      if (system.decided || system.beyond) break;
    }
    if (!system.decided && !system.beyond) continue;
    if (system.beyond && random.Chance(0.5)) continue;
    bool unfit = false;
    for (std::size_t i = 0; i < system.parts.size(); ++i) {
      const Expected& expected = system.expected[i];
      unfit |= expected.end.n > 200 || (system.parts[i]->has_levels() && expected.resolved < 16);
    }
    if (unfit) continue;
    const double duration = system.end - system.start;
    std::vector<std::pair<double, int>> at;  // times and numbers of ticks
    for (int i = 1 + random.Below(4); i > 0; --i) {
      const double t = system.start + duration * random.Uniform(0, 1);
      const int tick = static_cast<int>(std::floor((t - system.start) / ticks.period()));
      if (random.Chance(0.1)) {
        at.push_back({system.start, ticking ? 1 : 0});
      } else if (ticking && tick > 0 && random.Chance(0.3)) {
        at.push_back({static_cast<double>(system.start + ticks.Time(tick)), tick + 1});
      } else {
        at.push_back({t, 0});
      }
    }
    std::sort(at.begin(), at.end());
    for (const auto& [t, tick] : at) {
      const double ahead = t + (system.end - t) * random.Uniform(0, 1);
      system.cuts.push_back({t, static_cast<Division>(random.Below(5)), ahead, tick});
    }
    return system;
  }
}

// ---- Runs and their judgement ----

struct RunEnd {
  std::string error;        ///< empty: the run finished
  std::string wrong_ticks;  ///< empty: each tick has run until its time, and no other
  std::vector<Motion> motions;
};

RunEnd Run(const System& system, bool divided) {
  RunEnd end;
  try {
    DiagramBuilder builder;
    for (const auto& part : system.parts) part->Add(builder, part->name);
    const auto diagram = builder.Build();
    auto context = diagram->CreateContext();
    context->SetTime(system.start);
    auto simulator = std::make_unique<Simulator>(std::move(context), system.options);
    if (divided) {
      for (const Cut& cut : system.cuts) {
        simulator->RunTo(cut.time);
        for (const auto& part : system.parts) {
          const int ticks = part->Read(simulator->context()).ticks;
          if (cut.ticks > 0 && part->ticks() && ticks != cut.ticks) {
            end.wrong_ticks = part->name + " has run " + std::to_string(ticks) + " instead of " +
                              std::to_string(cut.ticks) + " ticks at t = " + std::to_string(cut.time);
          }
        }
        switch (cut.division) {
          case Division::kAdvance:
            break;
          case Division::kClone:
            simulator = std::make_unique<Simulator>(simulator->context().Clone(), system.options);
            break;
          case Division::kRestore:
            simulator->context().Restore(simulator->context().Save());
            break;
          case Division::kRestoreInNew: {
            auto fresh = diagram->CreateContext();
            fresh->Restore(simulator->context().Save());
            simulator = std::make_unique<Simulator>(std::move(fresh), system.options);
            break;
          }
          case Division::kRollout: {
            const auto saved = simulator->context().Save();
            try {
              simulator->RunTo(cut.ahead);
            } catch (const RunError&) {  // judged when the run itself arrives there
            }
            simulator->context().Restore(saved);
            break;
          }
        }
      }
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
constexpr const char* kVerdicts[] = {
    "right", "refused beyond doubles", "error that names nothing", "depends on division",
    "ended", "silently wrong"};

struct Judgement {
  Verdict verdict = Verdict::kRight;
  std::string text;
};

/// The time that a message names; NaN if none.
double TimeIn(const std::string& message) {
  const auto at = message.find("t = ");
  return at == std::string::npos ? NAN : std::strtod(message.c_str() + at + 4, nullptr);
}

Judgement Judge(const System& system, const RunEnd& end) {
  const Real duration = Real{system.end} - system.start;
  std::size_t first = system.parts.size();  // the part whose events accumulate first
  Real accumulates = duration;
  for (std::size_t i = 0; i < system.parts.size(); ++i) {
    if (system.expected[i].accumulates >= accumulates) continue;
    accumulates = system.expected[i].accumulates;
    first = i;
  }
  if (!end.error.empty()) {
    const double time = TimeIn(end.error);
    bool names = false;
    for (const auto& part : system.parts)
      names |= end.error.find("'" + part->name + ".") != std::string::npos;
    if (!names || std::isnan(time)) return {Verdict::kMute, end.error};
    const Real since = Real{time} - system.start;
    for (std::size_t i = 0; i < system.parts.size(); ++i) {
      const Expected& expected = system.expected[i];
      const std::string witness = "'" + system.parts[i]->name + "." + system.parts[i]->witness() + "'";
      if (expected.accumulates <= duration && since >= expected.early && since <= expected.late &&
          end.error.find(witness) != std::string::npos)
        return {};
    }
    if (system.beyond) return {Verdict::kRefused, end.error};
    return {Verdict::kEnded, end.error};
  }
  if (first < system.parts.size())
    return {Verdict::kWrong, system.parts[first]->name + " has passed the accumulation of its events"};
  if (!system.decided) return {};  // beyond doubles
  std::ostringstream os;
  os.precision(12);
  os << end.wrong_ticks;
  for (std::size_t i = 0; i < system.parts.size(); ++i) {
    const Motion &is = end.motions[i], &must = system.expected[i].end;
    const std::string& name = system.parts[i]->name;
    if (system.parts[i]->ticks() && is.ticks != must.ticks) {
      os << name << " has run " << is.ticks << " instead of " << must.ticks << " ticks; ";
    }
    if (is.n != must.n) os << name << " has " << is.n << " events instead of " << must.n << "; ";
    if (!(std::abs(is.x - must.x) <= system.expected[i].x_error))
      os << name << ".x is " << is.x << " instead of " << must.x << " +- " << system.expected[i].x_error
         << "; ";
    if (!(std::abs(is.v - must.v) <= system.expected[i].v_error))
      os << name << ".v is " << is.v << " instead of " << must.v << " +- " << system.expected[i].v_error
         << "; ";
  }
  return os.str().empty() ? Judgement{} : Judgement{Verdict::kWrong, os.str()};
}

/// Runs a system as a whole and divided; both must be right, and equal bit for bit.
Judgement RunAndJudge(const System& system) {
  const RunEnd whole = Run(system, false), divided = Run(system, true);
  Judgement judgement = Judge(system, whole), again = Judge(system, divided);
  if (again.verdict > judgement.verdict) judgement = {again.verdict, "divided: " + again.text};
  if (judgement.verdict > Verdict::kUnequal) return judgement;
  if (!system.decided) return judgement;  // beyond doubles
  if (whole.error != divided.error)
    return {Verdict::kUnequal, "whole: " + whole.error + "; divided: " + divided.error};
  for (std::size_t i = 0; i < whole.motions.size(); ++i) {
    const Motion &a = whole.motions[i], &b = divided.motions[i];
    if (a.x == b.x && a.v == b.v && a.n == b.n && a.mode == b.mode) continue;
    std::ostringstream os;
    os.precision(17);
    os << system.parts[i]->name << ": x " << a.x << " and " << b.x << ", v " << a.v << " and " << b.v
       << ", events " << a.n << " and " << b.n;
    return {Verdict::kUnequal, os.str()};
  }
  return judgement;
}

// ---- Tests ----

/// Counts of verdicts by a property of the systems.
using Counts = std::map<std::string, std::array<int, std::size(kVerdicts)>>;
void Print(const Counts& counts) {
  for (const auto& [key, row] : counts) {
    std::cout << "  " << key << std::string(key.size() < 30 ? 30 - key.size() : 1, ' ');
    for (const int n : row)
      std::cout << ' ' << std::string(n < 10 ? 4 : n < 100 ? 3 : n < 1000 ? 2 : n < 10000 ? 1 : 0, ' ') << n;
    std::cout << '\n';
  }
}

std::string Decade(const char* name, double value) {
  if (value == 0) return std::string(name) + " 0";
  const int decade = static_cast<int>(std::floor(std::log10(std::abs(value)) / 3 + 1e-9)) * 3;
  return std::string(name) + (value == 1 ? " 1" : " 1e" + std::to_string(decade) + " ..");
}

TEST(HybridPropertyTest, RandomSystemsAgreeWithTheExactSolution) {
  const auto number = [](const char* name, std::uint64_t otherwise) {
    const char* const text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
  };
  const std::uint64_t systems = number("TENON_HYBRID_SYSTEMS", 300), one = number("TENON_HYBRID_SYSTEM", 0);
  const std::uint64_t from = one != 0 ? one : 1, to = one != 0 ? one : systems;
  std::map<std::string, Counts> tables;
  for (std::uint64_t i = from; i <= to; ++i) {
    const System system = MakeSystem(i);
    if (one != 0) system.Describe(std::cout);
    const auto begin = std::chrono::steady_clock::now();
    const Judgement judgement = RunAndJudge(system);
    if (const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
        took.count() > 0.2)
      std::cout << took.count() << " s: " << system.Line() << ' ' << judgement.text.substr(0, 200)
                << std::endl;
    const auto verdict = static_cast<std::size_t>(judgement.verdict);
    if (judgement.verdict > Verdict::kRefused) {
      ADD_FAILURE() << kVerdicts[verdict] << ": " << system.Line() << "\n  " << judgement.text;
    }
    const Scale& scale = system.parts[0]->scale;
    const double offset = std::abs(scale.offset) / scale.length;
    ++tables["a family"][system.family()][verdict];
    ++tables["b method"][system.method()][verdict];
    ++tables["c length"][Decade("length", scale.length)][verdict];
    ++tables["d time"][Decade("time", system.time_scale)][verdict];
    ++tables["e offset"][Decade("offset", offset)][verdict];
    ++tables["f start"][Decade("t0", system.start)][verdict];
    ++tables["g all"]["all"][verdict];
    ++tables["h beyond"][system.beyond ? system.decided ? "beyond" : "beyond and undecided" : "within"]
            [verdict];
  }
  std::cout << "right, refused beyond doubles, error that names nothing, depends on division, ended, "
               "silently wrong\n";
  for (const auto& [property, counts] : tables) Print(counts);
}

// ---- Tests of the judge: blocks that do not do what the oracle expects ----

struct BallWithoutBounce final : BallPart {
  void Add(DiagramBuilder& builder, const std::string& name) override {
    BallParams other = p;
    other.restitution = -1;
    block = &builder.Add<Ball>(name, other);
  }
};

/// Bounces when it has fallen 1 % deeper.
struct LateBall final : BallPart {
  void Add(DiagramBuilder& builder, const std::string& name) override {
    BallParams other = p;
    other.floor -= 0.01 * (p.x - p.floor);
    block = &builder.Add<Ball>(name, other);
  }
};

/// A ball of 1 m above a floor at 0 that is run for 1.4 s, in which it hits the floor twice.
template <class BallType>
System Bouncing(Method method) {
  System system;
  auto part = std::make_unique<BallType>();
  part->p = {.x = 1,
             .v = 0,
             .gravity = 9.81,
             .floor = 0,
             .restitution = 0.8,
             .rest_below = 0,
             .crossing = Crossing::kFalling};
  part->name = "ball";
  system.parts.push_back(std::move(part));
  system.options.method = method;
  system.end = 1.4;
  Random random(1);
  Expect(&system, random);
  return system;
}

TEST(HybridPropertyTest, TheJudgeFindsAWrongBlock) {
  for (const Method method : kAllMethods) {
    EXPECT_EQ(RunAndJudge(Bouncing<BallPart>(method)).verdict, Verdict::kRight);
    EXPECT_EQ(RunAndJudge(Bouncing<BallWithoutBounce>(method)).verdict, Verdict::kWrong);
    EXPECT_EQ(RunAndJudge(Bouncing<LateBall>(method)).verdict, Verdict::kWrong);
  }
}

}  // namespace tenon::hybrid_property_test
