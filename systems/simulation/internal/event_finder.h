#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace tenon::internal {

/// Finds the first event in an integrator step: the first instant at which a function is zero or on the other
/// side of zero, or at which an integer-valued function (the index of a piece) changes.
///
/// A function that starts at zero, or whose event has just been handled and that is still zero within
/// rounding, has no side. It takes the side to which it moves, without an event.
///
/// A step is sampled at four places inside and at its end. Where a value is far from the cubic through its
/// neighbours, both halves are sampled in the same way, recursively. Where the polynomial through all values
/// comes close to zero between samples, the function is evaluated. The first change of side is then enclosed
/// by the Illinois method, with bisection where that converges slowly, to the rounding of the time.
class EventFinder {
 public:
  enum class Kind { kRising, kFalling, kBoth, kPiece };
  /// Computes the values of all functions at a time.
  using Evaluate = std::function<void(double time, double* values)>;

  /// `memory` contains the sides and belongs to the run; Start resizes it.
  EventFinder(std::vector<Kind> kinds, Evaluate evaluate, std::vector<double>* memory);

  bool empty() const { return kinds_.empty(); }
  std::size_t size() const { return kinds_.size(); }
  bool started() const { return memory_->size() == 3 * kinds_.size(); }
  /// Sets the side of every function from its value.
  void Start(const double* values);
  /// Sets the side of a function from its value after its event was handled. `found` is true if Find found
  /// the event, so that the function was zero within rounding, and false if the function jumped.
  void StartAgain(std::size_t i, double value, bool found);
  /// The first of the functions that have jumped to another side; the number of functions if none has.
  std::size_t FindJump(const double* values) const;
  /// Ends the search up to here without an event: sets the side of every function that is not zero.
  void Settle(const double* values);
  /// Returns whether there is an event in (from, to]. If there is, sets `time` and `fired` to its time and
  /// functions; if not, sets the sides to those at `to`.
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
  /// Per function: its side, -1, 1 or 0 if undecided (for a piece, its index); the magnitude below which it
  /// counts as zero after its last event; the largest magnitude in recent steps.
  std::vector<double>* memory_;
  std::vector<Sample> samples_;  ///< one per level of Look, and one more
  Sample first_, last_, low_, high_, try_;
};

}  // namespace tenon::internal
