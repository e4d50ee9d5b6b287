#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace tenon::internal {

/// The relative spacing of times at which functions can still be told apart: an event is located to this part
/// of its time.
inline constexpr double kTimeResolution = 0x1p-50;

/// Finds the first event in an integrator step: the first instant at which a function is zero or on the other
/// side of zero, or at which an integer-valued function (the index of a piece) changes.
///
/// All criteria are relative: to the rounding of the time, to the rounding of the function's own value, and
/// to the step.
///
/// A function that starts at zero, or whose event has just been handled and that is still zero within
/// rounding, has no side. Decide gives it the side to which the motion takes it, without an event.
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

  /// The motion after an instant, computed from the states and the dynamics at that instant alone.
  class Motion {
   public:
    /// Computes the values of all functions `ahead` [s] of the instant, to second or third order.
    virtual void Evaluate(double ahead, int order, double* values) = 0;
    /// Computes them on the straight line along the derivatives; `ahead` may be negative.
    virtual void EvaluateStraight(double ahead, double* values) = 0;
    /// Computes them at the instant, with the time and the states moved by `parts` of themselves; the sign of
    /// each state's change follows from `pattern`.
    virtual void EvaluateRounded(double parts, int pattern, double* values) = 0;

   protected:
    ~Motion() = default;
  };

  /// `memory` contains the sides and belongs to the run; Start resizes it.
  EventFinder(std::vector<Kind> kinds, Evaluate evaluate, std::vector<double>* memory);

  bool empty() const { return kinds_.empty(); }
  std::size_t size() const { return kinds_.size(); }
  bool started() const { return memory_->size() == kMemory * kinds_.size(); }
  /// Sets the side of every function from its value, at the instant of `motion`.
  void Start(const double* values, Motion& motion);
  /// Measures the rounding of the values, for StartAgain.
  void MeasureRounding(const double* values, Motion& motion);
  /// Sets the side of a function from its value after its event was handled. `found` is true if Find found
  /// the event, so that the function was zero within rounding, and false if the function jumped. `moved` is
  /// true if the event's updates may have changed the motion.
  void StartAgain(std::size_t i, double value, bool found, bool moved);
  /// Checks that the states at an event that Find found, before its updates, move the functions through zero:
  /// where the error of the states is larger than their motion, they need not. Looks ahead until a motion
  /// can be told from rounding, up to `reach` [s].
  void CheckSpeeds(const std::vector<std::size_t>& fired, double reach, Motion& motion);
  /// The first of the functions that have jumped to another side; the number of functions if none has.
  std::size_t FindJump(const double* values) const;
  /// Ends the search up to here without an event: sets the side of every function that is not zero.
  void Settle(const double* values);
  /// True if Decide must be called before the motion goes on.
  bool undecided() const;
  /// Gives functions that are zero within rounding the side to which the motion takes them within `reach`
  /// [s]. Returns the first function for which that cannot be resolved: whose event stopped it at zero,
  /// within rounding, and which is then driven to the other side. Returns the number of functions if there is
  /// none.
  std::size_t Decide(double time, double reach, Motion& motion);
  /// Returns whether there is an event in (from, to]. If there is, sets `time` and `fired` to its time and
  /// functions; if not, sets the sides to those at `to`.
  bool Find(double from, double to, double* time, std::vector<std::size_t>* fired);

 private:
  struct Sample {
    double time = 0;
    std::vector<double> values;
  };
  enum { kSides, kZeros, kOrigins, kMemory };
  double& Memory(int what, std::size_t i) { return (*memory_)[what * kinds_.size() + i]; }
  double Memory(int what, std::size_t i) const { return (*memory_)[what * kinds_.size() + i]; }
  bool Fires(std::size_t i, double value) const;
  bool AnyAtZero() const;
  void Take(double time, Sample* sample);
  void KeepZeros(const Sample& a, const Sample& b, const std::vector<std::size_t>& fired);
  bool Look(const Sample& a, const Sample& b, std::size_t depth, double* time,
            std::vector<std::size_t>* fired);
  bool LookBetween(const Sample& a, const Sample& b, double* time, std::vector<std::size_t>* fired);

  std::vector<Kind> kinds_;
  Evaluate evaluate_;
  /// Per function: its side, -1, 1 or 0 if undecided (for a piece, its index); the magnitude below which it
  /// counts as zero until it has left zero; where it came from while Decide must be called, else 0.
  std::vector<double>* memory_;
  double begin_ = 0;             ///< of the present search [s]
  std::vector<Sample> samples_;  ///< one per level of Look, and one more
  Sample first_, last_, low_, high_, try_;
  std::vector<double> rounding_;  ///< magnitudes within which the last measured values are zero
};

}  // namespace tenon::internal
