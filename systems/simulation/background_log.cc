#include <tenon/systems/io/internal/no_signals.h>
#include <tenon/systems/simulation/background_log.h>

#include <system_error>

namespace tenon {
namespace {

constexpr std::size_t kBlockSize = 1 << 13;  // numbers
constexpr auto kLongestWait = std::chrono::milliseconds(500);

}  // namespace

BackgroundLog::~BackgroundLog() {
  try {
    Flush();
  } catch (...) {
    // The run flushes at its end and reports the error there.
  }
  if (!thread_.joinable()) return;
  ends_ = true;
  work_.release();
  thread_.join();
}

void BackgroundLog::Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) {
  for (const auto& sink : sinks_) sink->Begin(names, units);
  columns_ = names.size();
  for (Block& block : blocks_) block.reserve(std::max(kBlockSize, columns_));
  try {
    const internal::NoSignals no_signals;
    thread_ = std::thread([this] {
      for (work_.acquire(); !ends_; work_.acquire()) Work();
    });
  } catch (const std::system_error&) {
    // The system has no thread left, so Row passes the blocks on itself.
  }
}

void BackgroundLog::Row(std::span<const double> row) {
  Block& block = blocks_[handed_ % kBlocks];
  block.insert(block.end(), row.begin(), row.end());
  const bool full = block.capacity() - block.size() < columns_;
  if (full || Clock::now() - handed_over_ > kLongestWait) HandOver();
}

/// Ends the current block, so that it can be passed on, and begins the next one.
void BackgroundLog::HandOver() {
  handed_over_ = Clock::now();
  ++handed_;
  work_.release();
  if (handed_ - done_ == kBlocks || !thread_.joinable()) Work();
  if (failed_) std::rethrow_exception(failure_);
}

/// Passes all waiting blocks to the sinks, in order. Any thread may call it.
void BackgroundLog::Work() {
  const std::lock_guard working(working_);
  for (; done_ != handed_; ++done_) {
    Block& block = blocks_[done_ % kBlocks];
    try {
      for (std::size_t i = 0; i < block.size() && !failed_; i += columns_) {
        for (const auto& sink : sinks_) sink->Row({&block[i], columns_});
      }
    } catch (...) {
      failure_ = std::current_exception();
      failed_ = true;
    }
    block.clear();
  }
}

void BackgroundLog::Flush() {
  Finish([](LogSink& sink) { sink.Flush(); });
}

void BackgroundLog::DropFrom(double time, bool after) {
  Finish([&](LogSink& sink) { sink.DropFrom(time, after); });
}

/// Waits until the sinks have all rows, then calls `then` for each sink.
void BackgroundLog::Finish(const std::function<void(LogSink&)>& then) {
  if (columns_ == 0) return;
  if (!blocks_[handed_ % kBlocks].empty()) HandOver();
  Work();
  {
    const std::lock_guard working(working_);
    for (const auto& sink : sinks_) then(*sink);
  }
  if (failed_) std::rethrow_exception(failure_);
}

}  // namespace tenon
