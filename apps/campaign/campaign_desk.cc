#include <tenon/apps/campaign/campaign_desk.h>

#include <fmt/core.h>

namespace tenon::apps {

CampaignDesk::CampaignDesk(CampaignSchedule& schedule, CampaignTable& table, std::size_t done)
    : schedule_(schedule), table_(table), before_(done) {}

bool CampaignDesk::Stopped() const {
  return failure_ || interrupted_ || SignalGuard::caught() != 0;
}

bool CampaignDesk::closed() {
  const std::lock_guard lock(mutex_);
  return Stopped() || schedule_.finished();
}

std::optional<std::size_t> CampaignDesk::Take() {
  std::unique_lock lock(mutex_);
  while (true) {
    if (Stopped()) return {};
    if (const auto run = schedule_.Next()) return run;
    if (schedule_.finished()) return {};
    changed_.wait_for(lock, std::chrono::milliseconds(100));  // a signal does not notify
  }
}

std::optional<std::size_t> CampaignDesk::TryTake() {
  const std::lock_guard lock(mutex_);
  if (Stopped()) return {};
  return schedule_.Next();
}

void CampaignDesk::Put(std::size_t run, const std::optional<CampaignResult>& result) {
  const std::lock_guard lock(mutex_);
  if (!result) {  // a signal stopped it, here or on another machine
    interrupted_ = true;
    changed_.notify_all();
    return;
  }
  if (!result->machine_failure.empty()) {
    constexpr std::size_t kMostInARow = 10;
    ++lost_;
    why_lost_ = result->machine_failure;
    const bool can_go_on = schedule_.Lost(run) && ++lost_in_a_row_ < kMostInARow;
    if (!can_go_on && !failure_)
      failure_ = std::make_exception_ptr(OutputError(
          fmt::format("run {} cannot be completed on this machine: {}; mend that, and continue with --resume",
                      run, why_lost_)));
    changed_.notify_all();
    return;
  }
  lost_in_a_row_ = 0;
  try {
    if (!failure_) table_.Append(result->row);
  } catch (...) {
    failure_ = std::current_exception();
  }
  schedule_.Done(run, result->survived);
  ++ended_;
  failures_ += result->survived ? 0 : 1;
  if (line_.due()) line_.Show(Share(), Text());
  changed_.notify_all();
}

void CampaignDesk::Close() {
  const std::lock_guard lock(mutex_);
  line_.End(Share(), Text());
  if (failure_) std::rethrow_exception(failure_);
}

std::optional<double> CampaignDesk::Share() const {
  const auto total = schedule_.total();
  if (!total) return {};
  return *total == 0 ? 1 : static_cast<double>(before_ + ended_) / static_cast<double>(*total);
}

std::string CampaignDesk::Text() const {
  const double wall = line_.elapsed();
  const double rate = wall > 0 ? static_cast<double>(ended_) / wall : 0;
  const std::size_t done = before_ + ended_;
  const auto total = schedule_.total();
  if (!total) return fmt::format("{} runs, {:.1f} a second, {} failed", done, rate, failures_);
  const double left = rate > 0 ? static_cast<double>(*total - std::min(done, *total)) / rate : 0;
  return fmt::format("{} of {} runs, {:.1f} a second, {:.0f} s left, {} failed", done, *total, rate, left,
                     failures_);
}

void WorkInThreads(CampaignDesk& desk, const CampaignRunner& runner, int jobs) {
  const auto work = [&] {
    while (const auto run = desk.Take()) desk.Put(*run, runner.Run(*run));
  };
  std::vector<std::jthread> others;
  try {
    for (int i = 1; i < jobs; ++i) others.emplace_back(work);
  } catch (const std::system_error& error) {
    Say(fmt::format("warning: running only {} jobs at a time: {}\n", others.size() + 1, error.what()));
  }
  work();
}

}  // namespace tenon::apps
