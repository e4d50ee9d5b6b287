#include <tenon/systems/simulation/internal/event_finder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace tenon::internal {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kRounding = 64 * kEpsilon;  ///< of a value, relative to the largest in recent steps
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
/// Fractions of a step after an event, because a function may return to zero at once.
constexpr std::array<double, 7> kProbes{1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3};

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
}

void EventFinder::Start(const double* values) {
  memory_->assign(3 * kinds_.size(), 0.0);
  Settle(values);
}

/// Returns whether a witness with this value is on a side of zero.
bool EventFinder::IsSide(std::size_t i, double value) const {
  return std::abs(value) > std::max(Memory(kZeros, i), kRounding * Memory(kScales, i));
}

bool EventFinder::Fires(std::size_t i, double value) const {
  const double side = Memory(kSides, i);
  if (kinds_[i] == Kind::kPiece) return value != side;
  return (side > 0 && value <= 0 && kinds_[i] != Kind::kRising) ||
         (side < 0 && value >= 0 && kinds_[i] != Kind::kFalling);
}

void EventFinder::Settle(const double* values) {
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i] == Kind::kPiece) {
      Memory(kSides, i) = values[i];
    } else if (IsSide(i, values[i])) {
      Memory(kSides, i) = values[i] > 0 ? 1 : -1;
      Memory(kZeros, i) = 0;
    }
  }
}

void EventFinder::StartAgain(std::size_t i, double value, bool found) {
  if (kinds_[i] == Kind::kPiece) {
    Memory(kSides, i) = value;
    return;
  }
  if (!found) Memory(kZeros, i) = 0;
  Memory(kSides, i) = 0;
  if (IsSide(i, value)) {
    Memory(kSides, i) = value > 0 ? 1 : -1;
    Memory(kZeros, i) = 0;
  }
}

std::size_t EventFinder::FindJump(const double* values) const {
  std::size_t i = 0;
  while (i < kinds_.size() && !Fires(i, values[i])) ++i;
  return i;
}

void EventFinder::Take(double time, Sample* sample) {
  sample->time = time;
  evaluate_(time, sample->values.data());
  for (std::size_t i = 0; i < kinds_.size(); ++i) {
    if (std::isfinite(sample->values[i]))
      Memory(kScales, i) = std::max(Memory(kScales, i), std::abs(sample->values[i]));
  }
}

bool EventFinder::Find(double from, double to, double* time, std::vector<std::size_t>* fired) {
  fired->clear();
  for (std::size_t i = 0; i < kinds_.size(); ++i) Memory(kScales, i) *= 0.5;
  Take(to, &last_);
  Take(from, &first_);
  bool undecided = false;
  for (std::size_t i = 0; i < kinds_.size(); ++i)
    undecided |= kinds_[i] != Kind::kPiece && Memory(kSides, i) == 0;
  if (undecided) {
    Sample& probe = samples_.back();
    for (const double part : kProbes) {
      Take(from + part * (to - from), &probe);
      if (LookBetween(first_, probe, time, fired)) return true;
      std::swap(first_, probe);
    }
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
    if (miss > kBends * largest && miss > kReachesZero * smallest && miss > kRounding * Memory(kScales, i))
      bends = true;
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
  for (int iteration = 0; iteration < 200; ++iteration) {
    const double width = high_.time - low_.time;
    const double resolution = 4 * kEpsilon * std::max(std::abs(low_.time), std::abs(high_.time));
    if (width <= resolution) break;
    double at = low_.time + width / 2;
    const std::size_t i = FindJump(high_.values.data());
    if (kinds_[i] != Kind::kPiece && iteration % 4 != 3) {
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
    Memory(kZeros, i) = 4 * std::abs(high_.values[i]);
  }
  return true;
}

}  // namespace tenon::internal
