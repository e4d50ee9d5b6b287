#include <tenon/systems/simulation/internal/event_finder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace tenon::internal {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kRounding = 64 * kEpsilon;  ///< of a value, relative to the largest beside it
constexpr double kBeside = 0x1p-32;          ///< of a value at an event, relative to the values beside it
constexpr std::size_t kMaxDepth = 9;         ///< levels of halving a step
constexpr std::size_t kMaxDips = 2;          ///< maximum number of dips that are sampled per interval
/// An interval is halved if a middle value differs from the cubic through the others by more than these
/// fractions of the largest and of the smallest magnitude.
constexpr double kBends = 0.02, kReachesZero = 0.25;
/// Extrema of the polynomial are sampled if they are closer to zero than this fraction of the samples beside
/// them.
constexpr double kDips = 0.2;
/// Sampled places as fractions of a step; uneven, so that they do not alias with a periodic function.
constexpr std::size_t kNumPlaces = 6;
constexpr std::array<double, kNumPlaces> kPlaces{0, 0.13, 0.32, 0.55, 0.79, 1};
constexpr std::size_t kPerDepth = kNumPlaces - 2 + kMaxDips;  ///< maximum samples per level
using Values = std::array<double, kNumPlaces>;
/// A function after its event is sampled at this many resolutions of time, and then at multiples of the time
/// since the event, because it may return to zero at once.
constexpr double kFirstProbe = 2, kNextProbe = 4;
/// The slope of a function at its event is measured over this many resolutions of time, at most, and over
/// this part of the time since the search began.
constexpr double kSlope = 256, kSlopePart = 0.125;
/// Origin of an undecided function that starts or has jumped. Otherwise the origin is its former side.
constexpr double kNoSide = 2;
/// Factor of the side in the origin of a function whose states had no speed through zero at the event.
constexpr double kUnresolved = 3;
/// Patterns of signs by which all states are moved to measure the rounding of a function.
constexpr int kPatterns = 3;

/// The k-th Lagrange polynomial of `nodes`, which is 1 at the k-th node and 0 at the others, evaluated at
/// `s`.
template <std::size_t n>
constexpr double Lagrange(const std::array<double, n>& nodes, std::size_t k, double s) {
  double weight = 1;
  for (std::size_t j = 0; j < n; ++j) {
    if (j != k) weight *= (s - nodes[j]) / (nodes[k] - nodes[j]);
  }
  return weight;
}

/// The value at place `k` minus the cubic through the two places before and after it.
double MissOfCubic(const Values& values, std::size_t k) {
  const std::array<double, 4> nodes{kPlaces[k - 2], kPlaces[k - 1], kPlaces[k + 1], kPlaces[k + 2]};
  return values[k] -
         (Lagrange(nodes, 0, kPlaces[k]) * values[k - 2] + Lagrange(nodes, 1, kPlaces[k]) * values[k - 1] +
          Lagrange(nodes, 2, kPlaces[k]) * values[k + 1] + Lagrange(nodes, 3, kPlaces[k]) * values[k + 2]);
}

/// Number of places inside each interval at which the polynomial through all values is evaluated.
constexpr std::size_t kInside = 5;
struct InsidePlace {
  double place = 0;
  std::array<double, kNumPlaces> weights{};
};
constexpr auto kInsidePlaces = [] {
  std::array<std::array<InsidePlace, kInside>, kNumPlaces - 1> table{};
  for (std::size_t k = 0; k + 1 < kNumPlaces; ++k) {
    for (std::size_t j = 0; j < kInside; ++j) {
      const double part = static_cast<double>(j + 1) / (kInside + 1);
      InsidePlace& inside = table[k][j];
      inside.place = kPlaces[k] + part * (kPlaces[k + 1] - kPlaces[k]);
      for (std::size_t m = 0; m < kNumPlaces; ++m) inside.weights[m] = Lagrange(kPlaces, m, inside.place);
    }
  }
  return table;
}();

/// Fraction of the step at which the polynomial through `values` comes closest to zero, or crosses it,
/// between two values on one side of zero; 0 if there is no such place.
double FindDip(const Values& values) {
  double dip = 0, deepest = kDips;
  for (std::size_t k = 0; k + 1 < kNumPlaces; ++k) {
    const double side = values[k] + values[k + 1] > 0 ? 1 : -1;
    const double beside = std::min(side * values[k], side * values[k + 1]);
    if (!(beside > 0)) continue;
    for (const InsidePlace& at : kInsidePlaces[k]) {
      double value = 0;
      for (std::size_t m = 0; m < kNumPlaces; ++m) value += at.weights[m] * values[m];
      if (side * value / beside >= deepest) continue;
      deepest = side * value / beside;
      dip = at.place;
    }
  }
  return dip;
}

}  // namespace

EventFinder::EventFinder(std::vector<Kind> kinds, Evaluate evaluate, std::vector<double>* memory)
    : kinds_(std::move(kinds)), evaluate_(std::move(evaluate)), memory_(memory) {
  samples_.resize(kPerDepth * (kMaxDepth + 1));
  for (Sample& sample : samples_) sample.values.resize(kinds_.size());
  for (Sample* sample : {&first_, &last_, &low_, &high_, &try_}) sample->values.resize(kinds_.size());
  rounding_.resize(kinds_.size());
}

void EventFinder::Start(const double* values, Motion& motion) {
  memory_->assign(kMemory * kinds_.size(), 0.0);
  MeasureRounding(values, motion);
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] == Kind::kPiece) continue;
    Memory(kOrigins, i) = kNoSide;
    Memory(kZeros, i) = rounding_[i];
  }
  Settle(values);
}

bool EventFinder::Fires(std::size_t i, double value) const {
  const double side = Memory(kSides, i);
  if (kinds_[i] == Kind::kPiece) return value != side;
  // Until it has left zero, a function is there within rounding.
  const double zero = Memory(kZeros, i);
  const auto passes = [zero](double towards) { return zero > 0 ? towards > zero : towards >= 0; };
  return (side > 0 && passes(-value) && kinds_[i] != Kind::kRising) ||
         (side < 0 && passes(value) && kinds_[i] != Kind::kFalling);
}

void EventFinder::Settle(const double* values) {
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] == Kind::kPiece) {
      Memory(kSides, i) = values[i];
    } else if (std::abs(values[i]) > Memory(kZeros, i)) {
      Memory(kSides, i) = values[i] > 0 ? 1 : -1;
      Memory(kZeros, i) = Memory(kOrigins, i) = 0;
    }
  }
}

void EventFinder::StartAgain(std::size_t i, double value, bool found, bool moved) {
  double& side = Memory(kSides, i);
  if (kinds_[i] == Kind::kPiece) {
    side = value;
    return;
  }
  Memory(kZeros, i) = std::max(found ? Memory(kZeros, i) : 0, rounding_[i]);
  const bool unresolved = Memory(kOrigins, i) == kUnresolved;
  Memory(kOrigins, i) = !moved ? 0 : !found ? kNoSide : unresolved ? kUnresolved * side : side;
  side = 0;
  if (std::abs(value) <= Memory(kZeros, i)) return;
  side = value > 0 ? 1 : -1;
  Memory(kZeros, i) = Memory(kOrigins, i) = 0;
}

std::size_t EventFinder::FindJump(const double* values) const {
  std::size_t i = 0;
  while (i < kinds_.size() && !Fires(i, values[i])) ++i;
  return i;
}

bool EventFinder::undecided() const {
  const auto begin = memory_->begin() + static_cast<std::ptrdiff_t>(kOrigins * kinds_.size());
  return started() && std::any_of(begin, memory_->end(), [](double origin) { return origin != 0; });
}

/// Returns whether a function has no side, or has not left zero.
bool EventFinder::AnyAtZero() const {
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] != Kind::kPiece && (Memory(kSides, i) == 0 || Memory(kZeros, i) > 0)) return true;
  }
  return false;
}

/// Measures by how much rounding changes each function. Changes that do not grow with the movement of the
/// states are jumps of the function instead.
void EventFinder::MeasureRounding(const double* values, Motion& motion) {
  constexpr double kParts = 2 * kEpsilon, kMore = 4;
  std::fill(rounding_.begin(), rounding_.end(), 0.0);
  for (int pattern = 0; pattern < kPatterns; ++pattern) {
    motion.EvaluateRounded(kParts, pattern, low_.values.data());
    motion.EvaluateRounded(kMore * kParts, pattern, high_.values.data());
    for (std::size_t i = 0; i < kinds_.size(); ++i) {
      const double change = std::abs(low_.values[i] - values[i]);
      if (std::abs(high_.values[i] - values[i]) >= kMore / 2 * change)
        rounding_[i] = std::max(rounding_[i], 2 * change);
    }
  }
}

void EventFinder::CheckSpeeds(const std::vector<std::size_t>& fired, double reach, Motion& motion) {
  bool clear = false;
  for (double ahead = kSlopePart * (high_.time - begin_); !clear; ahead *= 2) {
    motion.EvaluateStraight(ahead, try_.values.data());
    motion.EvaluateStraight(-ahead, last_.values.data());
    clear = true;
    for (const std::size_t i : fired) {
      if (kinds_[i] == Kind::kPiece) continue;
      const double returns = (try_.values[i] - last_.values[i]) * Memory(kSides, i);
      Memory(kOrigins, i) = returns >= 0 ? kUnresolved : 0;
      clear &= std::abs(returns) > Memory(kZeros, i) || ahead >= reach;
    }
  }
}

std::size_t EventFinder::Decide(double time, double reach, Motion& motion) {
  motion.EvaluateStraight(0, first_.values.data());
  auto open = std::count_if(memory_->begin() + static_cast<std::ptrdiff_t>(kOrigins * kinds_.size()),
                            memory_->end(), [](double origin) { return origin != 0; });
  const double begin = std::max(kFirstProbe * kTimeResolution * std::abs(time), kEpsilon * reach);
  for (double ahead = begin; open > 0 && ahead < reach; ahead *= 2) {
    std::vector<double>&values = low_.values, &rough = high_.values, &line = try_.values,
    &back = last_.values;
    motion.Evaluate(ahead, 3, values.data());
    const auto leaves = [&](std::size_t i) {
      return Memory(kOrigins, i) != 0 && std::abs(values[i]) > Memory(kZeros, i);
    };
    std::size_t i = 0;
    while (i < kinds_.size() && !leaves(i)) ++i;
    if (i == kinds_.size()) continue;
    motion.Evaluate(ahead, 2, rough.data());
    motion.EvaluateStraight(ahead, line.data());
    motion.EvaluateStraight(-ahead, back.data());
    for (; i < kinds_.size(); ++i) {
      // Farther ahead the two orders differ, and neither is right.
      if (!leaves(i) || !(std::abs(values[i] - rough[i]) <= 0.25 * std::abs(values[i]))) continue;
      const double side = values[i] > 0 ? 1 : -1;
      // A function passes through zero only with a speed that accounts for most of its way.
      const double by_speed = side * (line[i] - back[i]) / 2;
      const double origin = Memory(kOrigins, i);
      const bool resolved =
          std::abs(origin) != kUnresolved && by_speed >= 0.5 * side * (values[i] - first_.values[i]);
      if (!resolved && origin * side < 0 && std::abs(origin) != kNoSide) return i;
      Memory(kSides, i) = side;
      Memory(kOrigins, i) = 0;
      // Until it has left zero, zero is no event.
      Memory(kZeros, i) = std::max(Memory(kZeros, i), std::numeric_limits<double>::denorm_min());
      --open;
    }
  }
  // The others stay at zero; the search goes on to watch them.
  for (std::size_t i = 0; i < kinds_.size(); ++i) Memory(kOrigins, i) = 0;
  return kinds_.size();
}

void EventFinder::Take(double time, Sample* sample) {
  sample->time = time;
  evaluate_(time, sample->values.data());
}

bool EventFinder::Find(double from, double to, double* time, std::vector<std::size_t>* fired) {
  fired->clear();
  begin_ = from;
  Take(to, &last_);
  Take(from, &first_);
  const double step = to - from;
  double ahead = std::max(kFirstProbe * kTimeResolution * std::abs(from), kEpsilon * step);
  Sample& probe = samples_.back();
  for (; ahead < kPlaces[1] * step && AnyAtZero(); ahead *= kNextProbe) {
    Take(from + ahead, &probe);
    if (LookBetween(first_, probe, time, fired)) return true;
    std::swap(first_, probe);
  }
  return Look(first_, last_, 0, time, fired);
}

bool EventFinder::Look(const Sample& a, const Sample& b, std::size_t depth, double* time,
                       std::vector<std::size_t>* fired) {
  Sample* const inside = &samples_[kPerDepth * depth];
  constexpr std::size_t kNumInside = kNumPlaces - 2;
  for (std::size_t k = 0; k < kNumInside; ++k) Take(a.time + kPlaces[k + 1] * (b.time - a.time), &inside[k]);
  bool bends = false;
  std::array<double, kMaxDips> dips{};
  std::size_t num_dips = 0;
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] == Kind::kPiece) continue;
    const Values values{a.values[i],         inside[0].values[i], inside[1].values[i],
                        inside[2].values[i], inside[3].values[i], b.values[i]};
    double largest = 0, smallest = std::numeric_limits<double>::infinity();
    for (const double value : values) {
      largest = std::max(largest, std::abs(value));
      smallest = std::min(smallest, std::abs(value));
    }
    const double miss = std::max(std::abs(MissOfCubic(values, 2)), std::abs(MissOfCubic(values, 3)));
    if (miss > kBends * largest && miss > kReachesZero * smallest && miss > kRounding * largest) bends = true;
    if (const double dip = FindDip(values); dip > 0 && num_dips < dips.size()) dips[num_dips++] = dip;
  }
  if (bends && depth + 1 < kMaxDepth) {
    const Sample& middle = inside[kNumInside / 2];
    return Look(a, middle, depth + 1, time, fired) || Look(middle, b, depth + 1, time, fired);
  }
  std::array<const Sample*, kPerDepth + 1> samples{};  // in order of time
  std::size_t count = 0;
  const auto insert = [&](const Sample& sample) {
    std::size_t k = count++;
    for (; k > 0 && samples[k - 1]->time > sample.time; --k) samples[k] = samples[k - 1];
    samples[k] = &sample;
  };
  for (std::size_t k = 0; k < kNumInside; ++k) insert(inside[k]);
  for (std::size_t k = 0; k < num_dips; ++k) {
    Sample& dip = inside[kNumInside + k];
    Take(a.time + dips[k] * (b.time - a.time), &dip);
    insert(dip);
  }
  insert(b);
  const Sample* before = &a;
  for (std::size_t k = 0; k < count; ++k) {
    if (LookBetween(*before, *samples[k], time, fired)) return true;
    before = samples[k];
  }
  return false;
}

/// Returns whether a function changes its side between `a` and `b`, and where the first does. No event is at
/// `a`.
bool EventFinder::LookBetween(const Sample& a, const Sample& b, double* time,
                              std::vector<std::size_t>* fired) {
  if (FindJump(b.values.data()) == kinds_.size()) {
    Settle(b.values.data());
    return false;
  }
  // Copies, because evaluations overwrite the samples.
  low_ = a;
  high_ = b;
  double low_weight = 1, high_weight = 1;  // weights of the Illinois method
  for (int iteration = 0; iteration < 1000; ++iteration) {
    const double width = high_.time - low_.time;
    const double resolution = kTimeResolution * std::max(std::abs(low_.time), std::abs(high_.time));
    if (width <= resolution) break;
    // Far from the beginning of the search the interval is halved, close to it the order of magnitude.
    const double before = std::max(low_.time - begin_, resolution), after = high_.time - begin_;
    const bool close = after > 16 * before;
    double at = close ? begin_ + std::sqrt(before * after) : low_.time + width / 2;
    const std::size_t i = FindJump(high_.values.data());
    if (kinds_[i] != Kind::kPiece && iteration % 4 != 3 && !close) {
      const double low = low_weight * low_.values[i], high = high_weight * high_.values[i];
      if ((low > 0) != (high > 0) && std::isfinite(low - high)) {
        const double secant = low_.time + low / (low - high) * width;
        at = std::clamp(secant, low_.time + 0.5 * resolution, high_.time - 0.5 * resolution);
      }
    }
    if (!(at > low_.time && at < high_.time)) break;
    Take(at, &try_);
    if (FindJump(try_.values.data()) < kinds_.size()) {
      low_weight *= 0.5;
      high_weight = 1;
      std::swap(high_, try_);
    } else {
      high_weight *= 0.5;
      low_weight = 1;
      Settle(try_.values.data());
      std::swap(low_, try_);
    }
  }
  *time = high_.time;
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (!Fires(i, high_.values[i])) continue;
    fired->push_back(i);
  }
  KeepZeros(a, b, *fired);
  return true;
}

/// The magnitude below which functions count as zero after their event at `high_`: what they change by while
/// the time changes by its resolution, or the rounding of the samples beside them if that is larger. A
/// function that is farther from zero has jumped there. One that had not left zero before is still there.
void EventFinder::KeepZeros(const Sample& a, const Sample& b, const std::vector<std::size_t>& fired) {
  const double resolution = kTimeResolution * std::abs(high_.time);
  const double window = std::max(4 * resolution, kSlopePart * (high_.time - begin_));
  Take(std::max(a.time, high_.time - std::min(kSlope * resolution, window)), &low_);
  const double distance = high_.time - low_.time;
  for (const std::size_t i : fired) {
    const double slope = std::abs(high_.values[i] - low_.values[i]) / distance;
    const double beside = std::max(std::abs(a.values[i]), std::abs(b.values[i]));
    const double rounding = std::min(std::abs(high_.values[i]), kBeside * beside);
    Memory(kZeros, i) =
        2 * Memory(kZeros, i) + (distance > 0 ? std::max(2 * resolution * slope, rounding) : 0);
  }
}

}  // namespace tenon::internal
