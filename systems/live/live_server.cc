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
