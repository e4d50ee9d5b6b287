#pragma once

#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/systems/campaign/statistics.h>

#include <cstddef>
#include <map>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace tenon::apps {

/// The part i of n of a campaign, i from 1: of the runs every n-th.
struct Shard {
  std::size_t index = 1, count = 1;
  bool Has(std::size_t run) const { return run % count == index - 1; }
};

/// Which run comes next, and when enough is known. What it decides depends on the runs' results in the order
/// of their seeds, not on the order in which they come in: so for any number of workers the same runs belong
/// to the campaign. Where it estimates, some are started that turn out not to be needed.
class CampaignSchedule {
 public:
  /// `ahead`: how many runs of one point may be under way when the next ones may not be needed.
  CampaignSchedule(const CampaignPlan& plan, Shard shard, std::size_t ahead);

  /// The next run to start; none if all are under way or done.
  std::optional<std::size_t> Next();
  /// A run has ended, now or in an earlier process, and the robot survived it or not.
  void Done(std::size_t run, bool survived);
  bool finished() const;
  /// Whether a run is among those that count; once it is finished.
  bool Counts(std::size_t run) const;
  /// How many runs there are in this part, if that is known before.
  std::optional<std::size_t> total() const;

  /// What was found of a limit at a point: the largest value that was survived, and the smallest that was
  /// not.
  struct Limit {
    double survives = 0, fails = 0;
  };
  Limit LimitAt(std::size_t point) const;

 private:
  /// One value at one point, of which seed after seed is judged.
  struct Sequence {
    std::size_t level = 0;
    std::size_t judged = 0;    ///< of the seeds, from the first on
    std::size_t survived = 0;  ///< of these
    std::size_t next = 0;      ///< seed to start
    bool over = false;         ///< nothing is left to be known at the point
    int steps = 0;             ///< of a bisection, done
    Limit limit{};
  };
  bool adaptive() const;
  void Judge(std::size_t point);
  bool Decided(const Sequence& at) const;
  std::optional<std::size_t> NextFixed();
  std::optional<std::size_t> NextAdaptive();

  const CampaignPlan& plan_;
  Shard shard_;
  std::size_t ahead_;
  std::unordered_set<std::size_t> started_;  ///< and not done
  // Without an estimate:
  std::vector<bool> done_;
  std::size_t cursor_ = 0;
  // With one:
  std::vector<Sequence> sequences_;  ///< by point
  std::size_t turn_ = 0;             ///< the point that is asked next
  std::size_t open_ = 0;             ///< points that are not over
  std::unordered_map<std::size_t, bool> known_;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t>
      counted_;  ///< seeds that count, by point and level
};

}  // namespace tenon::apps
