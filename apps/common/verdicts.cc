#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/common/verdicts.h>

#include <fmt/core.h>

#include <numbers>

namespace tenon::apps {

PathVerdict::PathVerdict(double tolerance, double length, double offset, double turned)
    : judged_(true), heading_limit_(tolerance * std::numbers::pi + turned) {
  if (length > 0) position_limit_ = tolerance * length + offset;
}

void PathVerdict::Add(double time, double deviation, double turn) {
  if (!judged_) return;
  turn = std::abs(std::remainder(turn, 2 * std::numbers::pi));
  deviations_.Add(deviation);
  turns_.Add(turn);
  if (!left_ && position_limit_ && deviation > *position_limit_) left_ = time;
  if (!turned_ && turn > *heading_limit_) turned_ = time;
}

void PathVerdict::AddTo(Summary& summary) const {
  summary.SetFollowed(deviations_.max() ? std::optional(!left_ && !turned_) : std::nullopt);
  summary.Set("path_deviation_max_m", deviations_.max(), {.high = position_limit_});
  summary.Set("heading_deviation_max_rad", turns_.max(), {.high = heading_limit_});
  if (left_) {
    const auto [worst, limit] = Beside(*deviations_.max(), *position_limit_);
    summary.Break(*left_, fmt::format("the path was not followed: the robot left it by {} m, more than {} m",
                                      worst, limit));
  }
  if (turned_) {
    const auto [worst, limit] = Beside(*turns_.max(), *heading_limit_);
    summary.Break(*turned_,
                  fmt::format("the path was not followed: the heading deviated by {} rad, more than "
                              "{} rad",
                              worst, limit));
  }
}

void TaskBounds::Validate() const {
  if (at_least && at_most && *at_least > *at_most)
    throw ParameterError(fmt::format("at_least = {} must not be above at_most = {}", *at_least, *at_most));
}

void Task::AddTo(Summary& summary, double due, double weight, double length) const {
  for (const auto& [key, bounds] : figures) {
    const bool force = (key + ".").find("_N.") != std::string::npos;
    Limits limits{.low = bounds.at_least, .high = bounds.at_most};
    for (std::optional<double>* bound : {&limits.low, &limits.high})
      if (*bound) **bound *= force ? weight : key == "climb_m" ? length : 1;
    summary.Require(key, limits, due_s.value_or(due));
  }
}

}  // namespace tenon::apps
