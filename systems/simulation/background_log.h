#pragma once

#include <tenon/systems/simulation/signal_log.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <semaphore>
#include <thread>

namespace tenon {

/// Passes rows to other sinks in its own thread, so that a run does not wait for them:
///
///     simulator.AddLog(Hz(1000), signals, {std::make_shared<BackgroundLog>(csv)});
///
/// Rows are passed on in order, in blocks, at least every half second of wall-clock time. Row neither locks
/// nor allocates. The number of blocks is limited: if the sinks stay behind the run by 100,000 numbers, Row
/// waits for them and does part of their work. When the run pauses
/// or ends, Flush waits until the sinks have all rows; then their contents may be read.
///
/// An exception that a sink throws for a row is rethrown by a later Row and by every Flush; no sink gets
/// further rows.
class BackgroundLog final : public LogSink {
 public:
  /// Throws ParameterError for a sink that is null or belongs to another log.
  explicit BackgroundLog(std::vector<std::shared_ptr<LogSink>> sinks) : sinks_(std::move(sinks)) {
    Claim(sinks_, "BackgroundLog");
  }
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

  static constexpr std::size_t kBlocks = 16;
  std::size_t columns_ = 0;
  std::array<Block, kBlocks> blocks_;  ///< ring buffer; one block is filled while earlier ones are passed on
  Clock::time_point handed_over_ = Clock::now();

  std::atomic<std::size_t> handed_ = 0, done_ = 0;  ///< number of blocks filled, and of blocks passed on
  std::counting_semaphore<> work_{0};               ///< wakes the thread
  std::atomic<bool> ends_ = false, failed_ = false;
  std::exception_ptr failure_;  ///< constant once `failed_` is set

  std::mutex working_;  ///< locked while sinks run
  std::vector<std::shared_ptr<LogSink>> sinks_;
  std::thread thread_;
};

}  // namespace tenon
