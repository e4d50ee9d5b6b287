#pragma once

#include <tenon/systems/simulation/signal_log.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

namespace tenon {

/// Hands rows to other sinks in a thread of its own, so that a run does not wait for what they do:
///
///     simulator.AddLog(Hz(1000), signals, {std::make_shared<BackgroundLog>(csv)});
///
/// Rows come in order, block by block, with the first row after half a second of the clock at the latest.
/// Blocks are few: where the sinks are slower than the run, the run helps. When it pauses or ends, Flush
/// waits until all is done; what a sink has gathered may be read from then on.
///
/// What a sink throws for a row comes out of a later Row, and out of every Flush; none of them gets more
/// rows.
class BackgroundLog final : public LogSink {
 public:
  explicit BackgroundLog(std::vector<std::shared_ptr<LogSink>> sinks) : sinks_(std::move(sinks)) {}
  ~BackgroundLog() override;
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) override;
  void Row(std::span<const double> row) override;
  void Flush() override;
  void DropFrom(double time, bool after) override;

 private:
  using Clock = std::chrono::steady_clock;
  using Block = std::vector<double>;  ///< whole rows
  void Finish(const std::function<void(LogSink&)>& then);
  void HandOver();
  void Work();
  void RunThread();
  void ThrowFailure();

  static constexpr std::size_t kBlocks = 4;
  std::size_t columns_ = 0;
  std::array<Block, kBlocks> blocks_;  ///< a ring: one is filled, those before it wait or are worked on
  Clock::time_point handed_over_ = Clock::now();

  std::mutex working_;  ///< held while sinks work
  std::vector<std::shared_ptr<LogSink>> sinks_;

  std::mutex mutex_;  ///< of what follows
  std::condition_variable work_;
  std::size_t handed_ = 0, done_ = 0;  ///< blocks so far
  std::exception_ptr failure_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace tenon
