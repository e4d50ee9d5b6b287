#include <tenon/apps/campaign/campaign_schedule.h>

#include <algorithm>
#include <bit>

namespace tenon::apps {

CampaignSchedule::CampaignSchedule(const CampaignPlan& plan, Shard shard, std::size_t ahead)
    : plan_(plan), shard_(shard), ahead_(ahead) {
  if (!adaptive()) {
    done_.resize(plan.size());
    return;
  }
  sequences_.resize(plan.num_points());
  open_ = sequences_.size();
  if (plan.file().limit)
    for (Sequence& at : sequences_) at.limit = {plan.file().limit->from, plan.file().limit->to};
}

bool CampaignSchedule::adaptive() const {
  return plan_.file().limit || plan_.file().estimate == Estimate::kSurvival;
}

std::optional<std::size_t> CampaignSchedule::Next() {
  return adaptive() ? NextAdaptive() : NextFixed();
}

/// Runs all points with the first seed, then with the second, so that an interrupted campaign covers all
/// points.
std::optional<std::size_t> CampaignSchedule::NextFixed() {
  for (; cursor_ < plan_.size(); ++cursor_) {
    const std::size_t run = plan_.RunOf(cursor_ % plan_.num_points(), 0, cursor_ / plan_.num_points());
    if (done_[run] || !shard_.Has(run)) continue;
    ++cursor_;
    started_.insert(run);
    return run;
  }
  return {};
}

std::optional<std::size_t> CampaignSchedule::NextAdaptive() {
  for (std::size_t i = 0; i < sequences_.size(); ++i) {
    const std::size_t point = turn_++ % sequences_.size();
    Sequence& at = sequences_[point];
    if (at.over) continue;
    for (; at.next < plan_.num_seeds() && at.next < at.judged + ahead_; ++at.next) {
      const std::size_t run = plan_.RunOf(point, at.level, at.next);
      if (known_.contains(run) || !started_.insert(run).second) continue;
      ++at.next;
      return run;
    }
  }
  return {};
}

void CampaignSchedule::Done(std::size_t run, bool survived) {
  started_.erase(run);
  if (!adaptive()) {
    done_[run] = true;
    return;
  }
  known_[run] = survived;
  Judge(plan_.PointOf(run));
}

bool CampaignSchedule::Lost(std::size_t run) {
  started_.erase(run);
  return !adaptive();
}

void CampaignSchedule::Judge(std::size_t point) {
  Sequence& at = sequences_[point];
  while (!at.over) {
    const auto result = known_.find(plan_.RunOf(point, at.level, at.judged));
    if (result == known_.end()) return;
    ++at.judged;
    at.survived += result->second ? 1 : 0;
    if (at.judged < plan_.num_seeds() && !Decided(at)) continue;

    counted_[{point, at.level}] = at.judged;
    if (!plan_.file().limit || ++at.steps == plan_.file().limit->steps) at.over = true;
    if (plan_.file().limit) {
      const bool survives = static_cast<double>(at.survived) >=
                            plan_.file().limit->probability * static_cast<double>(at.judged);
      (survives ? at.limit.survives : at.limit.fails) = plan_.LevelValue(at.level);
      at.level = 2 * at.level + (survives ? 2 : 1);
      at.judged = at.survived = at.next = 0;
    }
    if (at.over) --open_;
  }
}

bool CampaignSchedule::Decided(const Sequence& at) const {
  const CampaignFile& file = plan_.file();
  if (!file.limit)
    return WilsonInterval(at.survived, at.judged, file.confidence).width() <= file.interval_width;
  // Tests after 8, 16, 32, … seeds share the risk of a wrong decision.
  constexpr std::size_t kFirstLook = 8;
  if (at.judged % kFirstLook != 0 || !std::has_single_bit(at.judged / kFirstLook)) return false;
  const auto looks = static_cast<double>(std::bit_width(plan_.num_seeds() / kFirstLook));
  const double confidence = 1 - (1 - file.confidence) / looks;
  const Interval interval = WilsonInterval(at.survived, at.judged, confidence);
  return interval.low > file.limit->probability || interval.high < file.limit->probability;
}

bool CampaignSchedule::finished() const {
  return adaptive() ? open_ == 0 : cursor_ >= plan_.size() && started_.empty();
}

bool CampaignSchedule::Counts(std::size_t run) const {
  if (!adaptive()) return run < plan_.size();
  const auto found = counted_.find({plan_.PointOf(run), plan_.LevelOf(run)});
  return found != counted_.end() && run % plan_.num_seeds() < found->second;
}

std::optional<std::size_t> CampaignSchedule::total() const {
  if (adaptive()) return {};
  const std::size_t rest = plan_.size() % shard_.count;
  return plan_.size() / shard_.count + (shard_.index <= rest ? 1 : 0);
}

CampaignSchedule::Limit CampaignSchedule::LimitAt(std::size_t point) const {
  return sequences_[point].limit;
}

}  // namespace tenon::apps
