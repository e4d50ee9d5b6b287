#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace tenon::internal {

/// Finds the first event in a step of the integrator: the first instant at which a function, which was on one
/// side of zero, is on zero or beyond, or at which an integer-valued function (a piece) changes.
///
/// A function that starts on zero, or whose event has just been handled and that is still within rounding of
/// zero, has no side; it takes the side to which it leaves, without an event.
///
/// A step is looked at in four places inside and at its end. Where a value is far from the cubic through its
/// neighbours, both halves are looked at in the same way, and so on; where the polynomial through all values
/// comes close to zero in between, the function is evaluated there. The first change of side is then enclosed
/// by the Illinois method, with bisection where that is slow, to the rounding of the time.
class EventFinder {
 public:
  enum class Kind { kRising, kFalling, kBoth, kPiece };
  /// Computes the values of all functions at a time.
  using Evaluate = std::function<void(double time, double* values)>;

  /// `memory` holds the sides, which belong to the run; it is resized by Start.
  EventFinder(std::vector<Kind> kinds, Evaluate evaluate, std::vector<double>* memory);

  bool empty() const { return kinds_.empty(); }
  std::size_t size() const { return kinds_.size(); }
  bool started() const { return memory_->size() == 3 * kinds_.size(); }
  /// Every function is on the side of its value.
  void Start(const double* values);
  /// A function whose event has been handled starts anew from its value. `found` says that Find found the
  /// event, so that the function was on zero but for rounding; a function that has jumped was not.
  void StartAgain(std::size_t i, double value, bool found);
  /// The first function that has come to another side, at one instant; the number of functions if none has.
  std::size_t FindJump(const double* values) const;
  /// No event up to here: every function that is beyond zero is on that side.
  void Settle(const double* values);
  /// Whether there is an event in (from, to]; if so, `time` and `fired` say when and of which functions, else
  /// sides are those at `to`.
  bool Find(double from, double to, double* time, std::vector<std::size_t>* fired);

 private:
  struct Sample {
    double time = 0;
    std::vector<double> values;
  };
  enum { kSides, kZeros, kScales };
  double& Memory(int what, std::size_t i) { return (*memory_)[what * kinds_.size() + i]; }
  double Memory(int what, std::size_t i) const { return (*memory_)[what * kinds_.size() + i]; }
  bool IsSide(std::size_t i, double value) const;
  bool Fires(std::size_t i, double value) const;
  void Take(double time, Sample* sample);
  bool Look(const Sample& a, const Sample& b, std::size_t depth, double* time,
            std::vector<std::size_t>* fired);
  bool LookBetween(const Sample& a, const Sample& b, double* time, std::vector<std::size_t>* fired);

  std::vector<Kind> kinds_;
  Evaluate evaluate_;
  /// Per function: its side, -1, 1, or 0 on zero (of a piece, its number); the magnitude up to which it is on
  /// zero after its last event; the largest magnitude in recent steps.
  std::vector<double>* memory_;
  std::vector<Sample> samples_;  ///< of each level of Look, and one more
  Sample first_, last_, low_, high_, try_;
};

}  // namespace tenon::internal
