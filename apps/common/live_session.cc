#include <tenon/apps/common/live_session.h>

#include <fmt/format.h>

namespace tenon::apps {

LiveSession::LiveSession(const LiveSessionOptions& options) : options_(options) {
  if (options.replay) {
    recording_ = LiveRecording::Read(*options.replay);
    return;
  }
  server_ = std::make_unique<LiveServer>(
      LiveOptions{.address = options.address, .port = options.port, .returns_for_reset = true});
  Say(fmt::format("live: {}\n", server_->url()));
}
LiveSession::~LiveSession() = default;

RunOutcome LiveSession::Advance(Simulator& simulator, const LiveView& view, double duration,
                                const std::filesystem::path& out) {
  if (recording_) {
    const std::optional<double> until = options_.duration ? options_.duration
                                        : recording_->end ? std::nullopt
                                                          : std::optional<double>(duration);
    StopOnSignal(simulator);
    try {
      return Observe(simulator, [&] { return Replay(simulator, *recording_, until); });
    } catch (const ParameterError& error) {
      throw ParameterError(fmt::format("--replay {}: {}", options_.replay->string(), error.what()));
    }
  }
  server_->options().recording = out.empty() ? out : out / "live.jsonl";
  server_->options().stop = [] { return SignalGuard::caught() != 0; };
  RunOutcome outcome = Observe(simulator, [&] { return server_->Run(simulator, view, options_.duration); });
  server_->options().stop = nullptr;
  return outcome;
}

std::optional<std::uint64_t> LiveSession::reset_seed() const {
  return server_ ? server_->reset_seed() : std::nullopt;
}
std::optional<std::uint64_t> LiveSession::replay_seed() const {
  return recording_ ? std::optional(recording_->seed) : std::nullopt;
}

}  // namespace tenon::apps
