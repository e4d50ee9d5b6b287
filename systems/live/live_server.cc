#include <tenon/systems/framework/diagram/internal/program.h>
#include <tenon/systems/live/internal/live_run.h>
#include <tenon/systems/live/live_server.h>

#include <fmt/format.h>

namespace tenon {

struct LiveServer::Impl {
  LiveOptions options;
  internal::LiveChannel channel{options.history};
  internal::LiveHttp http{options.address, options.port, channel};
  internal::LiveRun* run = nullptr;  ///< the current run; null between runs
  std::optional<std::uint64_t> reset_seed{};
  LiveStatus last{};
};

LiveServer::LiveServer(LiveOptions options) {
  const auto demand = [](const char* name, double value) {
    if (!(value > 0 && value < 1e6)) throw ParameterError(fmt::format("LiveOptions: {} = {} s", name, value));
  };
  demand("history", options.history);
  demand("frame", options.frame);
  internal::CheckPageParts();
  impl_.reset(new Impl{std::move(options)});
}
LiveServer::~LiveServer() = default;

const std::string& LiveServer::url() const {
  return impl_->http.url();
}
int LiveServer::port() const {
  return impl_->http.port();
}
LiveOptions& LiveServer::options() {
  return impl_->options;
}
std::optional<std::uint64_t> LiveServer::reset_seed() const {
  return impl_->reset_seed;
}

RunStatus LiveServer::Run(Simulator& simulator, const LiveView& view, std::optional<double> duration) {
  impl_->reset_seed.reset();
  impl_->http.SetPage(internal::MakePage(view.title, internal::PageData(view, impl_->http.token())));
  internal::LiveRun run(simulator, view, impl_->options, impl_->channel);
  struct Present {
    Impl& impl;
    ~Present() {
      impl.last = impl.run->status();
      impl.reset_seed = impl.run->reset_seed();
      impl.run = nullptr;
    }
  };
  impl_->run = &run;
  const Present present{*impl_};
  return run.Run(duration);
}

std::string LiveServer::Command(const std::string& client, const std::string& json) {
  if (impl_->run == nullptr) return internal::Refusal(503, "there is no run").json;
  return impl_->run->Execute(client, json).json;
}

LiveStatus LiveServer::status() const {
  return impl_->run == nullptr ? impl_->last : impl_->run->status();
}

}  // namespace tenon

namespace tenon::internal {
namespace {

using std::chrono::milliseconds;

constexpr double kSnapshotPeriod = 0.5;     // interval of snapshots in the run's time [s]
constexpr milliseconds kLongestWait(50);    // interval of polling for commands
constexpr milliseconds kMessagePeriod(28);  // wall-clock interval of sample messages
constexpr milliseconds kStatusPeriod(200);
constexpr milliseconds kCatchUp(500);         // delay beyond which the run does not catch up
constexpr std::chrono::seconds kRateOver(1);  // interval over which the rate is measured

}  // namespace

LiveRun::LiveRun(Simulator& simulator, const LiveView& view, const LiveOptions& options, LiveChannel& channel)
    : simulator_(simulator),
      view_(view),
      options_(options),
      channel_(channel),
      file_(options.recording, simulator.context().seed()),
      parameters_(Tunable(simulator.context().diagram())),
      wanted_rate_(options.rate) {
  simulator_.HoldLogs(options.history + 2 * kSnapshotPeriod);
  simulator_.AddLog(options.signal_rate, view.signals, {WithDerived(view.plots, signals_)});
  if (!view.shapes.empty())
    simulator_.AddLog(options.frame_rate, {view.shapes.begin(), view.shapes.end()}, {frames_});
  Begin();
}

/// Mutes the sinks, because the simulator keeps them after the run.
LiveRun::~LiveRun() {
  signals_->muted = frames_->muted = true;
  signals_->Clear();
  frames_->Clear();
}

void LiveRun::Begin() {
  try {
    start_ = context().Save();
  } catch (const Error& error) {
    message_ = fmt::format("This run cannot go back: {}", error.what());
  }
  ended_ = simulator_.Initialize();
  if (ended_.ended) state_ = State::kEnded;
  snapshots_.clear();
  TakeSnapshot();
  RestartClock();

  Geometry shapes;
  for (const auto* port : view_.shapes) {
    const Geometry& more = context().Eval(*port);
    shapes.insert(shapes.end(), more.begin(), more.end());
  }
  shown_.clear();
  for (const ParameterSource* parameter : parameters_)
    shown_.push_back(ParameterValue(*parameter, context()));
  Json names = Json::array(), units = Json::array();
  for (std::size_t i = 1; i < signals_->names().size(); ++i) {
    names.push_back(signals_->names()[i]);
    units.push_back(signals_->units()[i]);
  }
  channel_.Begin(Dump(Hello(view_, shapes, context(), parameters_, options_.history)),
                 "\"names\":" + Dump(names) + ",\"units\":" + Dump(units));
  Publish(true);
}

RunStatus LiveRun::Run(std::optional<double> duration) {
  try {
    return Serve(duration);
  } catch (...) {
    try {
      simulator_.ReleaseLogs();  // passes held rows to their sinks
    } catch (const OutputError&) {
    }
    throw;
  }
}

RunStatus LiveRun::Serve(std::optional<double> duration) {
  for (;;) {
    ServeRequests();
    LetGoIfAbandoned();
    const bool stopped = options_.stop && options_.stop();  // may execute commands
    if (stopped || stop_) return Finish({time(), true, "interrupted"}, false);
    if (reset_seed_) return Finish({time(), true, "reset"}, false);
    const auto now = Clock::now();
    if (state_ == State::kRunning) {
      if (duration && time() >= *duration - 1e-9) {
        Advance(*duration, true);
        if (state_ != State::kEnded) return Finish({time(), false, "", nullptr}, true);
      } else if (wanted_rate_ > 0 && now < Due()) {
        channel_.WaitUntil(std::min(Due(), now + kLongestWait));
      } else {
        if (wanted_rate_ > 0) late_.Add(std::chrono::duration<double>(now - Due()).count());
        if (wanted_rate_ > 0 && now > Due() + kCatchUp) RestartClock();
        Advance(duration ? std::min(NextFrame(), *duration) : NextFrame());
        compute_.Add(std::chrono::duration<double>(Clock::now() - now).count());
      }
    } else if (state_ == State::kEnded && (duration || channel_.clients() == 0)) {
      return Finish(ended_, true);
    } else {
      channel_.WaitUntil(now + kLongestWait);
    }
    Publish(false);
  }
}

RunStatus LiveRun::Finish(RunStatus status, bool tick) {
  if (state_ == State::kEnded) {  // and was then stopped
    status = ended_;
    tick = true;
  }
  state_ = State::kEnded;
  ended_ = status;
  Publish(true);
  file_.End(time(), tick);
  simulator_.ReleaseLogs();
  if (failure_) std::rethrow_exception(failure_);
  return status;
}

void LiveRun::Advance(double until, bool to_tick) {
  try {
    const RunStatus status = to_tick ? simulator_.AdvanceTo(until) : simulator_.AdvanceToBefore(until);
    if (status.ended) {
      ended_ = status;
      state_ = State::kEnded;
      SayEvent(status.reason);
    } else if (!to_tick && !signals_->muted && time() - snapshots_.back().time >= kSnapshotPeriod - 1e-9) {
      TakeSnapshot();  // before the tick, so that commands at this time affect it
    }
  } catch (const Error& error) {
    failure_ = std::current_exception();
    ended_ = {time(), true, error.what()};
    state_ = State::kEnded;
  }
}

double LiveRun::NextFrame() const {
  return (std::floor(time() / options_.frame + 1e-6) + 1) * options_.frame;
}

LiveRun::Clock::time_point LiveRun::Due() const {
  const std::chrono::duration<double> since((time() - clock_start_time_) / wanted_rate_);
  return clock_start_ + std::chrono::duration_cast<Clock::duration>(since);
}

void LiveRun::RestartClock() {
  clock_start_ = Clock::now();
  clock_start_time_ = time();
  pace_.clear();
}

void LiveRun::TakeSnapshot() {
  std::vector<std::byte> bytes;
  try {
    if (message_.empty()) bytes = context().Save();
  } catch (const Error& error) {
    message_ = fmt::format("This run cannot go back: {}", error.what());
    snapshots_.clear();
  }
  snapshots_.push_back({time(), std::move(bytes), file_.entries().size()});
  while (snapshots_.size() > 1 && snapshots_[1].time <= time() - options_.history) snapshots_.pop_front();
}

void LiveRun::MeasureRate() {
  const auto now = Clock::now();
  if (!pace_.empty() && time() < pace_.back().second) pace_.clear();
  pace_.emplace_back(now, time());
  while (pace_.size() > 2 && pace_.front().first < now - kRateOver) pace_.pop_front();
  const double passed = std::chrono::duration<double>(now - pace_.front().first).count();
  rate_ = passed > 0 ? (time() - pace_.front().second) / passed : 0;
}

/// Sends samples and the status, each at most once in its period unless `now` is set.
void LiveRun::Publish(bool now) {
  const auto clock = Clock::now();
  if (now || clock - published_ >= kMessagePeriod) {
    published_ = clock;
    std::string body;
    if (!signals_->empty()) body = signals_->Take("values", false);
    if (!frames_->empty())
      body += std::string(body.empty() ? "" : ",") + "\"frames\":{" + frames_->Take("columns", true) + "}";
    if (!body.empty()) channel_.Append(time(), std::move(body));
    if (pulls_ && view_.controls.pull->state) {
      const auto [point, force] = view_.controls.pull->state(context());
      pull_["point_W"] = {point[0], point[1], point[2]};
      pull_["force_N"] = {force[0], force[1], force[2]};
    }
    channel_.SetPull(Dump(pulls_ ? pull_ : Json::object()));
  }
  if (now || clock - status_published_ >= kStatusPeriod) PublishStatus();
}

void LiveRun::PublishStatus() {
  status_published_ = Clock::now();
  MeasureRate();
  Json json{{"time", time()},
            {"state", status().state},
            {"rate_wanted", wanted_rate_ > 0 ? Json(wanted_rate_) : Json(nullptr)},
            {"rate", state_ == State::kRunning ? std::round(100 * rate_) / 100 : 0.0},
            {"driver", HasDriver() ? Json(driver_) : Json(nullptr)},
            {"clients", channel_.clients()},
            {"refused", channel_.refused()},
            {"times", {{"late", TimesJson(late_)}, {"computed in", TimesJson(compute_)}}}};
  if (state_ == State::kEnded) json["end_reason"] = ended_.reason;
  if (!message_.empty()) json["message"] = message_;
  channel_.SetStatus(Dump(json));
}

LiveStatus LiveRun::status() const {
  const char* const state = state_ == State::kRunning  ? "running"
                            : state_ == State::kPaused ? "paused"
                                                       : "ended";
  return {time(), state, state_ == State::kRunning ? rate_ : 0, channel_.clients(), channel_.refused()};
}

void LiveRun::Back(double to) {
  if (!message_.empty()) throw ParameterError(message_);
  if (snapshots_.empty() || to < snapshots_.front().time)
    throw ParameterError(fmt::format("the run can go back at most to {:.4g} s", snapshots_.front().time));
  if (to > time()) throw ParameterError(fmt::format("the run is at {:.4g} s and can only go back", time()));
  Publish(true);
  while (snapshots_.back().time > to) snapshots_.pop_back();
  const Snapshot& from = snapshots_.back();
  signals_->muted = frames_->muted = true;
  context().Restore(from.bytes);
  failure_ = nullptr;
  if (state_ == State::kEnded) state_ = State::kPaused;
  for (std::size_t i = from.entries; i < file_.entries().size(); ++i) {
    const LiveEntry& entry = file_.entries()[i];
    if (entry.time >= to) break;
    Advance(entry.time);
    ApplyEntry(context(), entry);
  }
  Advance(to);
  signals_->muted = frames_->muted = false;
  file_.DropFrom(to);
  const LiveControls& controls = view_.controls;
  drives_ = controls.drive && IsHeld(controls.drive->set(Vec<3>::Zero()));
  pulls_ = false;  // the pull ends, because the body has moved
  if (controls.pull && IsHeld(controls.pull->release())) Apply(controls.pull->release());
  RestartClock();
  // The tick at this time has not happened yet and sends its samples again.
  channel_.Say(time(), "back", Dump({{"to_s", std::max(0.0, time() - 1e-9)}}));
  SayChangedParameters();
  PublishStatus();
}

void LiveRun::Reset(std::uint64_t seed) {
  if (options_.returns_for_reset) {
    reset_seed_ = seed;
    return;
  }
  if (!message_.empty()) throw ParameterError(message_);
  context().Restore(start_);
  const auto fresh = context().diagram().CreateContext(seed);
  for (const Cell& cell : context().diagram().program().cells) {
    if (cell.source->kind() != SourceKind::kRandom) continue;
    const auto& stream = static_cast<const Random&>(*cell.source);
    context().Set(stream, fresh->Eval(stream));
  }
  file_ = LiveFile(options_.recording, seed);
  failure_ = nullptr;
  drives_ = pulls_ = false;
  tuned_.clear();
  signals_->Clear();
  frames_->Clear();
  state_ = State::kRunning;
  channel_.Clear();
  Begin();
}

}  // namespace tenon::internal
