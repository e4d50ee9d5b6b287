#include <tenon/systems/framework/diagram/internal/schedule.h>

#include <fmt/core.h>

#include <numeric>

namespace tenon::internal {
namespace {
constexpr std::int64_t kMaxTicksPerSecond = 1'000'000'000'000;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMaxTicks = kNever / 4;  // of a period, an offset or the begin of a run

[[noreturn]] void ThrowTooLate(double time) {
  throw RunError(fmt::format(
      "t = {} s is too late for the common tick of all sample times: round them, so that it is coarser",
      time));
}
}  // namespace

Schedule::Schedule(const std::vector<SampleGroup>& groups) {
  for (const SampleGroup& group : groups) {
    for (const std::int64_t denominator : {group.period.denominator, group.offset.denominator}) {
      const std::int64_t factor = denominator / std::gcd(per_second_, denominator);
      if (factor > kMaxTicksPerSecond / per_second_) {
        throw BuildError(fmt::format(
            "the sample times of '{}' and '{}' have no common tick above a picosecond: round their periods",
            groups.front().example, group.example));
      }
      per_second_ *= factor;
    }
  }
  for (const SampleGroup& group : groups) {
    const auto ticks = [&](const Rational& time) {
      const std::int64_t factor = per_second_ / time.denominator;
      if (time.numerator > kMaxTicks / factor)
        throw BuildError(
            fmt::format("the sample times of '{}' and '{}' have so fine a common tick that a period or an "
                        "offset of {:g} s "
                        "has too many: round them",
                        groups.front().example, group.example,
                        static_cast<double>(time.numerator) / static_cast<double>(time.denominator)));
      return time.numerator * factor;
    };
    const std::int64_t offset = ticks(group.offset);
    entries_.push_back({ticks(group.period), offset, offset, group.feeds});
    const double period = Time(entries_.back().period);
    if (shortest_period_ == 0 || period < shortest_period_) {
      shortest_period_ = period;
      finest_ = group.example;
    }
    if (group.feeds && !(shortest_feeding_period_ > 0 && shortest_feeding_period_ <= period))
      shortest_feeding_period_ = period;
  }
  due_.reserve(entries_.size());
  FindNext();
}

void Schedule::MoveTo(double time, bool inclusive) {
  // The first tick to be run. The product may round to a tick before or after `time`.
  const auto per_second = static_cast<double>(per_second_);
  if (!(std::abs(time) * per_second < static_cast<double>(kMaxTicks))) ThrowTooLate(time);
  CheckResolution(time);
  auto first = static_cast<std::int64_t>(std::floor(time * per_second));
  const auto counts = [&](double tick_time) { return inclusive ? tick_time >= time : tick_time > time; };
  while (!counts(static_cast<double>(first) / per_second)) ++first;
  for (Entry& entry : entries_) {
    const std::int64_t late = first - entry.offset;
    const std::int64_t periods = late <= 0 ? 0 : (late + entry.period - 1) / entry.period;
    entry.next = entry.offset + periods * entry.period;
  }
  FindNext();
}

void Schedule::CheckResolution(double time) const {
  constexpr double kFewest = 16;  // times that a double can hold within a period
  const double resolution = std::nextafter(std::abs(time), HUGE_VAL) - std::abs(time);
  if (entries_.empty() || shortest_period_ >= kFewest * resolution) return;
  throw RunError(fmt::format(
      "t = {} s is too late for the period of {:g} s of '{}', because a double resolves only {:.2g} "
      "s there: begin the run at an earlier time, such as 0, and add the rest where times are shown",
      time, shortest_period_, finest_, resolution));
}

const Groups& Schedule::Take() {
  due_.clear();
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].next != next_tick_) continue;
    due_.push_back(static_cast<int>(i));
    if (entries_[i].next > kNever - 1 - entries_[i].period) ThrowTooLate(Time(next_tick_));
    entries_[i].next += entries_[i].period;
  }
  FindNext();
  return due_;
}

double Schedule::Time(std::int64_t tick) const {
  return tick == kNever ? std::numeric_limits<double>::infinity()
                        : static_cast<double>(tick) / static_cast<double>(per_second_);
}

/// The part of a tick's time that Time cannot hold.
double Schedule::Rest(std::int64_t tick) const {
  if (tick == kNever) return 0;
  const auto rounded = static_cast<double>(tick);
  const auto left = static_cast<double>(tick - static_cast<std::int64_t>(rounded));
  const auto per_second = static_cast<double>(per_second_);
  return (std::fma(-Time(tick), per_second, rounded) + left) / per_second;
}

double Schedule::previous_time() const {
  std::int64_t previous = -kNever;
  for (const Entry& entry : entries_) {
    if (entry.next > entry.offset) previous = std::max(previous, entry.next - entry.period);
  }
  return previous == -kNever ? -std::numeric_limits<double>::infinity() : Time(previous);
}

double Schedule::following_time() const {
  std::int64_t following = kNever;
  for (const Entry& entry : entries_)
    following = std::min(following, entry.next == next_tick_ ? entry.next + entry.period : entry.next);
  return Time(following);
}

void Schedule::FindNext() {
  std::int64_t& feeding = next_feeding_tick_;
  feeding = next_tick_ = kNever;
  for (const Entry& entry : entries_) {
    next_tick_ = std::min(next_tick_, entry.next);
    if (entry.feeds) feeding = std::min(feeding, entry.next);
  }
  next_time_ = Time(next_tick_);
  next_feeding_time_ = feeding == next_tick_ ? next_time_ : Time(feeding);
}

}  // namespace tenon::internal
