#include <tenon/systems/simulation/internal/step_interpolant.h>

#include <algorithm>
#include <cmath>

namespace tenon::internal {
namespace {

constexpr double kFirst = 0.2, kSecond = 0.8;  ///< θ of the derivatives inside the step
constexpr double kSettled = 0.3;               ///< required contraction of successive corrections
constexpr double kNoise = 0x1p-46;             ///< of a correction, relative to the largest term

/// d/dθ of θ² (1 - θ)² and of θ³ (1 - θ)².
constexpr double QuarticSlope(double s) {
  return 2 * s * (1 - s) * (1 - 2 * s);
}
constexpr double QuinticSlope(double s) {
  return s * s * (1 - s) * (3 - 5 * s);
}

}  // namespace

StepInterpolant::StepInterpolant(int num_states, int degree, bool implicit)
    : degree_(degree), implicit_(implicit) {
  const auto size = static_cast<std::size_t>(num_states);
  for (auto* vector : {&x0_, &x1_, &f0_, &f1_, &slope1_, &a_, &b_, &x_, &f_, &g_}) vector->resize(size);
  if (implicit) past_.reserve((kMaxPast + 1) * (size + 1));
}

void StepInterpolant::Restart() {
  started_ = prepared_ = has_f0_ = false;
  past_.clear();
}

void StepInterpolant::SetStep(double t0, const double* x0, double t1, const double* x1) {
  if (t1 == t0) return;
  if (implicit_ && started_) {
    past_.push_back(t0_);
    past_.insert(past_.end(), x0_.begin(), x0_.end());
    const std::size_t row = x0_.size() + 1;
    if (past_.size() > kMaxPast * row)
      past_.erase(past_.begin(), past_.begin() + static_cast<std::ptrdiff_t>(row));
  }
  // The derivative at the end of one step is reused at the beginning of the next.
  const bool follows = prepared_ && t0 == t1_ && std::equal(x1_.begin(), x1_.end(), x0);
  if (follows) f0_ = slope1_;
  has_f0_ = follows;  // f0 is now the derivative at t0
  t0_ = t0, t1_ = t1;
  std::copy_n(x0, x0_.size(), x0_.begin());
  std::copy_n(x1, x1_.size(), x1_.begin());
  prepared_ = false;
  started_ = true;
}

double StepInterpolant::HermiteSlope(double s, std::size_t i) const {
  return 6 * s * (1 - s) * (x1_[i] - x0_[i]) + (1 - s) * (1 - 3 * s) * f0_[i] + s * (3 * s - 2) * f1_[i];
}

void StepInterpolant::EvaluateHermite(double s, double* x) const {
  const double r = 1 - s, bump = s * s * r * r;
  const double h01 = s * s * (3 - 2 * s), h10 = s * r * r, h11 = -s * s * r;
  for (std::size_t i = 0; i < x0_.size(); ++i) {
    x[i] = x0_[i] + (h01 * (x1_[i] - x0_[i]) + h10 * f0_[i] + h11 * f1_[i] + bump * (a_[i] + b_[i] * s));
  }
}

void StepInterpolant::Prepare(DerivativeSource& source) {
  const double h = t1_ - t0_;
  if (!has_f0_) source.EvaluateForInterpolant(t0_, x0_.data(), f0_.data());
  source.EvaluateForInterpolant(t1_, x1_.data(), slope1_.data());
  f1_ = slope1_;
  for (std::size_t i = 0; i < f0_.size(); ++i) f0_[i] *= h, f1_[i] *= h;
  std::fill(a_.begin(), a_.end(), 0.0);
  std::fill(b_.begin(), b_.end(), 0.0);
  prepared_ = true;
  stiff_ = false;
  if (degree_ < 4 && !implicit_) return;

  const auto evaluate = [&](double s, std::vector<double>& f) {
    EvaluateHermite(s, x_.data());
    source.EvaluateForInterpolant(t0_ + s * h, x_.data(), f.data());
    for (double& value : f) value *= h;
  };
  evaluate(kFirst, f_);
  for (std::size_t i = 0; i < a_.size(); ++i) {
    a_[i] = (f_[i] - HermiteSlope(kFirst, i)) / QuarticSlope(kFirst);
  }
  if (degree_ < 5 && !implicit_) return;
  evaluate(kFirst, f_);
  if (implicit_) {
    double first = 0, left = 0;
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const double change = (f_[i] - HermiteSlope(kFirst, i)) / QuarticSlope(kFirst) - a_[i];
      const double largest = std::abs(x0_[i]) + std::abs(x1_[i]) + std::abs(f0_[i]) + std::abs(f1_[i]);
      first += a_[i] * a_[i];
      if (std::abs(change) > kNoise * largest) left += change * change;
    }
    stiff_ = left > kSettled * kSettled * first;
    if (degree_ < 4) std::fill(a_.begin(), a_.end(), 0.0);
    if (degree_ < 5 || stiff_) return;
  }
  evaluate(kSecond, g_);
  // a p(θ) + b q(θ) = slope error of Hermite's cubic, at both points.
  constexpr double p1 = QuarticSlope(kFirst), q1 = QuinticSlope(kFirst);
  constexpr double p2 = QuarticSlope(kSecond), q2 = QuinticSlope(kSecond);
  constexpr double determinant = p1 * q2 - p2 * q1;
  for (std::size_t i = 0; i < a_.size(); ++i) {
    const double d1 = f_[i] - HermiteSlope(kFirst, i), d2 = g_[i] - HermiteSlope(kSecond, i);
    a_[i] = (d1 * q2 - d2 * q1) / determinant;
    b_[i] = (p1 * d2 - p2 * d1) / determinant;
  }
}

/// Lagrange's polynomial through the states.
void StepInterpolant::EvaluateThroughStates(double t, double* x) const {
  const std::size_t size = x0_.size(), count = past_.size() / (size + 1) + 2;
  const auto time = [&](std::size_t i) {
    return i + 2 < count ? past_[i * (size + 1)] : i + 2 == count ? t0_ : t1_;
  };
  const auto states = [&](std::size_t i) {
    return i + 2 < count ? &past_[i * (size + 1) + 1] : i + 2 == count ? x0_.data() : x1_.data();
  };
  std::fill_n(x, size, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    double weight = 1;
    for (std::size_t j = 0; j < count; ++j) {
      if (j != i) weight *= (t - time(j)) / (time(i) - time(j));
    }
    for (std::size_t k = 0; k < size; ++k) x[k] += weight * states(i)[k];
  }
}

void StepInterpolant::At(double t, DerivativeSource& source, double* x) {
  if (!prepared_) Prepare(source);
  stiff_ ? EvaluateThroughStates(t, x) : EvaluateHermite((t - t0_) / (t1_ - t0_), x);
}

}  // namespace tenon::internal
