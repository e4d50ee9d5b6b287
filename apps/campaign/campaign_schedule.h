#pragma once

#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/systems/campaign/statistics.h>

#include <unordered_map>
#include <unordered_set>

namespace tenon::apps {

/// Part `index` of `count` parts of a campaign, counted from 1. It consists of every `count`-th run.
struct Shard {
  std::size_t index = 1, count = 1;
  bool Has(std::size_t run) const { return run % count == index - 1; }
};

/// Selects the next run and decides when an estimate is precise enough. Decisions depend on results in the
/// order of the seeds, not in the order of completion, so that the same runs belong to the campaign for any
/// number of workers. When estimating, some runs are started that turn out to be unnecessary.
class CampaignSchedule {
 public:
  /// `ahead` limits the number of runs of one point that are started before it is known whether they are
  /// needed.
  CampaignSchedule(const CampaignPlan& plan, Shard shard, std::size_t ahead);

  /// Returns the next run to start; empty if all are started or done.
  std::optional<std::size_t> Next();
  /// Records the result of a run of this or an earlier process.
  void Done(std::size_t run, bool survived);
  /// Records that a started run has no result and is not run again. Returns whether the campaign can be
  /// finished without it.
  bool Lost(std::size_t run);
  bool finished() const;
  /// Returns whether a run belongs to the campaign. Valid once the schedule is finished.
  bool Counts(std::size_t run) const;
  /// Returns the number of runs of this part, if it is known in advance.
  std::optional<std::size_t> total() const;

  /// The limit found at a point: the largest value that was survived and the smallest that was not.
  struct Limit {
    double survives = 0, fails = 0;
  };
  Limit LimitAt(std::size_t point) const;

 private:
  /// The state of a point, whose seeds are judged in order at one value.
  struct Sequence {
    std::size_t level = 0;
    std::size_t judged = 0;    ///< number of judged seeds
    std::size_t survived = 0;  ///< number of survivors among them
    std::size_t next = 0;      ///< seed to start
    bool over = false;         ///< the point is decided
    int steps = 0;             ///< completed bisection steps
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
  std::unordered_set<std::size_t> started_;  ///< started and not done
  // Used without an estimate.
  std::vector<bool> done_;
  std::size_t cursor_ = 0;
  // Used with an estimate.
  std::vector<Sequence> sequences_;  ///< by point
  std::size_t turn_ = 0;             ///< the point that is tried next
  std::size_t open_ = 0;             ///< number of undecided points
  std::unordered_map<std::size_t, bool> known_;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t>
      counted_;  ///< number of seeds that belong to the campaign, by point and level
};

}  // namespace tenon::apps
