// Members that say when something happens, one block for each; the results are compared with closed forms.

#include <tenon/systems/block.h>
#include <tenon/tests/testing/test_rig.h>

#include "near.h"

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace tenon;

// A ball falls from 1 m and bounces with half of its speed.
class Ball final : public LeafSystem<void> {
 public:
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "height, speed"}, Vec<2>(1, 0)};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[1], -9.81); }};
  Witness floor{this, "floor", Crossing::kFalling, Uses(x), [](const Vec<2>& x) { return x[0]; }};
  Update<Vec<2>> bounce{x, floor, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[0], -0.5 * x[1]); }};
};

bool CheckWitness() {
  TestRig<Ball> rig;
  const double fall = std::sqrt(2 / 9.81);
  rig.RunTo(1.5 * fall);  // the highest point after the first bounce
  return Near("Witness", rig[rig->x][0], 0.25);
}

enum class Heater { kOff, kOn };
// A heater warms a room by 2 K/h from 19 to 21 degrees; then the room cools by 1 K/h. Times are in hours.
class Room final : public LeafSystem<void> {
 public:
  ContinuousState<double> T{this, {"T", "degC"}, 20};
  Mode<Heater> heater{this, "heater", Heater::kOn};
  TimeDerivative<double> dT{T, Uses(heater), [](Heater h) { return h == Heater::kOn ? 2.0 : -1.0; }};
  Witness warm{this, "warm", Crossing::kRising, Uses(T), [](double T) { return T - 21; }};
  Witness cold{this, "cold", Crossing::kFalling, Uses(T), [](double T) { return T - 19; }};
  Update<Heater> off{heater, warm, Uses(), [] { return Heater::kOff; }};
  Update<Heater> on{heater, cold, Uses(), [] { return Heater::kOn; }};
};

bool CheckMode() {
  TestRig<Room> rig;
  rig.RunTo(3);  // off at 0.5, on at 2.5
  return Near("Mode", rig[rig->T], 20);
}

// The largest deflection of an oscillator so far, as fine as the steps of the integrator are.
class Swing final : public LeafSystem<void> {
 public:
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s"}, Vec<2>(0, 1)};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[1], -x[0]); }};
  DiscreteState<double> peak{this, {"peak", "m"}};
  Update<double> keep{peak, EachStep{}, Uses(peak, x),
                      [](double peak, const Vec<2>& x) { return std::max(peak, x[0]); }};
};

bool CheckEachStep() {
  TestRig<Swing> rig;
  rig.RunTo(3);
  return Near("EachStep", rig[rig->peak], 1, 1 - std::cos(0.05));  // steps are at most 0.1 s long
}

// A low-pass filter that starts at its input, without a transient.
class Filter final : public LeafSystem<void> {
 public:
  InputPort<double> u{this, {"u", "V"}};
  ContinuousState<double> x{this, {"x", "V"}};
  TimeDerivative<double> dx{x, Uses(x, u), [](double x, double u) { return (u - x) / 0.2; }};
  Update<double> begin{x, AtStart{}, Uses(u), [](double u) { return u; }};
};

bool CheckAtStart() {
  TestRig<Filter> rig;
  rig.Fix(rig->u, 5).RunTo(0.1);
  return Near("AtStart", rig[rig->x], 5);
}

// A pump that is on from 1 s to 2 s fills a tank by 3 l/s.
class Pump final : public LeafSystem<void> {
 public:
  NextJump next{this, "next", Uses(time), [](double t) { return t < 1 ? 1.0 : t < 2 ? 2.0 : kNever; }};
  ContinuousState<double> volume{this, {"volume", "l"}};
  TimeDerivative<double> flow{volume, Uses(time), [](double t) { return t >= 1 && t < 2 ? 3.0 : 0.0; }};
};

bool CheckNextJump() {
  TestRig<Pump> rig;
  rig.RunTo(3);
  return Near("NextJump", rig[rig->volume], 3, 1e-12);
}

// A mass of 1 kg flies at 1 m/s against a spring of 1 N/m, which acts where x > 0, and flies back.
class Bumper final : public LeafSystem<void> {
 public:
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s"}, Vec<2>(-1, 1)};
  Kink contact{this, "contact", Uses(x), [](const Vec<2>& x) { return x[0] > 0 ? 1 : 0; }};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[1], -std::max(0.0, x[0])); }};
};

bool CheckKink() {
  TestRig<Bumper> rig;
  rig.RunTo(1 + std::numbers::pi + 1);  // to the spring, half a period, and back
  return Near("Kink", rig[rig->x][0], -1);
}

int main() {
  const bool good[] = {CheckWitness(), CheckMode(),     CheckEachStep(),
                       CheckAtStart(), CheckNextJump(), CheckKink()};
  return std::ranges::find(good, false) == std::end(good) ? 0 : 1;
}
