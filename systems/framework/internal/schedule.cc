#include <tenon/systems/framework/internal/schedule.h>

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <numeric>

#include <tenon/systems/framework/errors.h>

namespace tenon::internal {
namespace {
constexpr std::int64_t kMaxTicksPerSecond = 1'000'000'000'000;
}

Schedule::Schedule(std::vector<SampleGroup> groups) {
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
    const std::int64_t offset = group.offset.numerator * (per_second_ / group.offset.denominator);
    entries_.push_back({group.period.numerator * (per_second_ / group.period.denominator), offset, offset});
  }
  FindNext();
}

void Schedule::MoveTo(double time, bool inclusive) {
  // The first tick that counts. The product may round up to a tick that `time` is short of, or past.
  const auto per_second = static_cast<double>(per_second_);
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

std::uint64_t Schedule::Take() {
  std::uint64_t due = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].next != next_tick_) continue;
    due |= std::uint64_t{1} << i;
    entries_[i].next += entries_[i].period;
  }
  FindNext();
  return due;
}

std::int64_t Schedule::cycle_end() const {
  constexpr std::int64_t kHuge = std::int64_t{1} << 62;
  std::int64_t cycle = 1, latest_offset = 0;
  for (const Entry& entry : entries_) {
    latest_offset = std::max(latest_offset, entry.offset);
    const std::int64_t factor = entry.period / std::gcd(cycle, entry.period);
    if (cycle > kHuge / factor) return kHuge;
    cycle *= factor;
  }
  return latest_offset + cycle;
}

void Schedule::FindNext() {
  if (entries_.empty()) {
    next_time_ = std::numeric_limits<double>::infinity();
    return;
  }
  next_tick_ = entries_.front().next;
  for (const Entry& entry : entries_) next_tick_ = std::min(next_tick_, entry.next);
  next_time_ = static_cast<double>(next_tick_) / static_cast<double>(per_second_);
}

}  // namespace tenon::internal
