#include <tenon/systems/files/output_file.h>
#include <tenon/systems/live/internal/bounded_server.h>
#include <tenon/systems/live/internal/live_channel.h>

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <random>
#include <thread>
#include <vector>

namespace tenon::internal {
namespace {

constexpr int kPortsTried = 20;
constexpr int kBacklog = 64;                 // number of connections that wait to be accepted
constexpr std::size_t kMaxBody = 1 << 16;    // maximal size of a command [bytes]
constexpr std::size_t kMaxName = 64;         // maximal length of a client's name [bytes]
constexpr std::chrono::seconds kBegins(10);  // time to wait for the begin of a run

std::string RandomToken() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", random());
  return token;
}

/// Encodes an address for a URL.
std::string HostOf(const std::string& address) {
  return address.find(':') == address.npos ? address : "[" + address + "]";
}

}  // namespace

struct LiveHttp::Impl {
  LiveChannel& channel;
  BoundedServer server;
  std::string url, token;
  int port = 0;
  std::vector<std::string> hosts;  // accepted names of this server; not checked if there is a token
  std::mutex mutex;
  std::condition_variable changed;  // the page is available or the server ends
  std::string page;
  bool ends = false;
  std::thread thread;

  explicit Impl(LiveChannel& channel) : channel(channel) {}

  void Answer(httplib::Response& response, const LiveReply& reply) {
    if (reply.status >= 400) channel.CountRefused();
    response.status = reply.status;
    response.set_content(reply.json, "application/json");
  }

  /// Returns whether a browser sent the request for a page of another site. Such a page may only open the
  /// page of this server in a window, as a link does.
  static bool IsFromOtherSite(const httplib::Request& request) {
    const std::string site = request.get_header_value("Sec-Fetch-Site");
    if (site.empty() || site == "same-origin" || site == "none") return false;
    return request.method != "GET" || request.path != "/" ||
           request.get_header_value("Sec-Fetch-Mode") != "navigate" ||
           request.get_header_value("Sec-Fetch-Dest") != "document";
  }

  /// Returns whether the request comes from the page of this server or not from a page at all. A page of
  /// another origin sends its origin or its relation to this site, and a page after DNS rebinding sends a
  /// host name other than those of this server.
  bool Admit(const httplib::Request& request, httplib::Response& response) {
    server.Received();
    for (const char* name : {"Host", "Origin", "Sec-Fetch-Site", "Sec-Fetch-Mode", "Sec-Fetch-Dest"}) {
      if (request.get_header_value_count(name) > 1) {
        Answer(response, Refusal(400, fmt::format("the header {} is given twice", name)));
        return false;
      }
    }
    const std::string host = request.get_header_value("Host");
    const std::string origin = request.get_header_value("Origin");
    if (IsFromOtherSite(request)) {
      Answer(response,
             Refusal(403, fmt::format("requests from the pages of other sites are refused: open {}", url)));
    } else if (token.empty() && std::ranges::find(hosts, host) == hosts.end()) {
      Answer(response, Refusal(403, fmt::format("the name of this server is not '{}': open {}", host, url)));
    } else if (!origin.empty() && origin != "http://" + host) {
      Answer(response, Refusal(403, fmt::format("commands from the page of '{}' are refused", origin)));
    } else if (request.get_param_value("token") != token) {
      Answer(response, Refusal(403, "the token is wrong: open the address that the run printed"));
    } else {
      return true;
    }
    return false;
  }

  /// Returns the client's name; empty if it is invalid.
  static std::string Client(const httplib::Request& request) {
    std::string client = request.get_param_value("client");
    return client.size() <= kMaxName ? client : "";
  }

  void Serve() {
    server.set_payload_max_length(kMaxBody);
    server.set_tcp_nodelay(true);
    server.set_default_headers({{"Content-Security-Policy", "frame-ancestors 'none'"},
                                {"X-Frame-Options", "DENY"},
                                {"Cross-Origin-Opener-Policy", "same-origin"}});
    server.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      if (!request.has_header("Content-Encoding")) return httplib::Server::HandlerResponse::Unhandled;
      // A thousand times the payload limit may come out of a compressed body.
      Answer(response, Refusal(415, "a command must not be compressed: omit Content-Encoding"));
      return httplib::Server::HandlerResponse::Handled;
    });
    server.Get("/", [this](const httplib::Request& request, httplib::Response& response) {
      if (!Admit(request, response)) return;
      std::unique_lock lock(mutex);
      if (!changed.wait_for(lock, kBegins, [this] { return ends || !page.empty(); }) || page.empty())
        return Answer(response, Refusal(503, "the run has not begun: reload the page"));
      response.set_header("Cache-Control", "no-store");
      response.set_content(page, "text/html; charset=utf-8");
    });
    server.Get("/events", [this](const httplib::Request& request, httplib::Response& response) {
      if (!Admit(request, response)) return;
      const auto reader = std::make_shared<LiveChannel::Reader>(channel, Client(request));
      if (!reader->admitted() || !server.BeginStream())
        return Answer(response, Refusal(503, "too many browsers are connected: close one"));
      response.set_header("Cache-Control", "no-store");
      response.set_chunked_content_provider("text/event-stream",
                                            [reader](std::size_t, httplib::DataSink& sink) {
                                              const std::string text = reader->Next();
                                              if (text.empty()) {
                                                sink.done();
                                                return true;
                                              }
                                              return sink.write(text.data(), text.size());
                                            });
    });
    server.Post("/command", [this](const httplib::Request& request, httplib::Response& response) {
      if (!Admit(request, response)) return;
      const std::string type = request.get_header_value("Content-Type");
      if (type != "application/json" && !type.starts_with("application/json;"))
        return Answer(response, Refusal(415, "a command must have the Content-Type application/json"));
      const std::string client = Client(request);
      if (client.empty())
        return Answer(
            response,
            Refusal(400,
                    "the name of the client is missing: use /command?client=ID with at most 64 characters"));
      Answer(response, channel.Ask(client, request.body));
    });
    server.set_error_handler([this](const httplib::Request&, httplib::Response& response) {
      if (!response.body.empty()) return;
      const char* const why = response.status == 404   ? "the page does not exist: open /"
                              : response.status == 413 ? "a command may have at most 64 kB"
                                                       : "the request is invalid";
      Answer(response, Refusal(response.status, why));
    });
    server.set_exception_handler(
        [this](const httplib::Request&, httplib::Response& response, std::exception_ptr) {
          Answer(response, Refusal(500, "the server failed"));
        });
    thread = std::thread([this] { server.listen_after_bind(); });
    while (!server.is_running())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // stop() before that has no effect
  }
};

LiveHttp::LiveHttp(const std::string& address, int port, LiveChannel& channel)
    : impl_(std::make_unique<Impl>(channel)) {
  // Without SO_REUSEPORT, which httplib sets, a port in use is detected.
  int listening = -1;
  const auto set_options = [&] {
    impl_->server.set_socket_options([&listening](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
      listening = socket;
    });
  };
  const bool local = address == "127.0.0.1" || address == "localhost";
  if (port == 0) {
    set_options();
    impl_->port = impl_->server.bind_to_any_port(address);
  } else {
    for (int tried = port; tried < port + kPortsTried && tried < 65536 && impl_->port == 0; ++tried) {
      impl_ = std::make_unique<Impl>(channel);  // since httplib 0.18, a server that failed cannot try again
      set_options();
      if (impl_->server.bind_to_port(address, tried)) impl_->port = tried;
    }
  }
  if (impl_->port <= 0) {
    throw OutputError(fmt::format(
        "cannot listen at {} on port {} or the next ones: choose another port or an address of this "
        "machine",
        address, port));
  }
  ::listen(listening, kBacklog);  // httplib's own backlog is 5
  if (!local) impl_->token = RandomToken();
  std::string shown = HostOf(address);
  const bool any = address == "0.0.0.0" || address == "::";
  if (std::array<char, 256> name{}; any && gethostname(name.data(), name.size() - 1) == 0)
    shown = name.data();
  impl_->url = fmt::format("http://{}:{}/", shown, impl_->port);
  if (!local) impl_->url += "?token=" + impl_->token;
  for (const std::string& name : {std::string("localhost"), std::string("127.0.0.1"), HostOf(address)})
    impl_->hosts.push_back(fmt::format("{}:{}", name, impl_->port));
  impl_->Serve();
}

LiveHttp::~LiveHttp() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->ends = true;
  }
  impl_->changed.notify_all();
  impl_->channel.Close();
  impl_->server.stop();
  impl_->thread.join();
  impl_->server.EndConnections();
}

void LiveHttp::SetPage(std::string html) {
  const std::lock_guard lock(impl_->mutex);
  impl_->page = std::move(html);
  impl_->changed.notify_all();
}

const std::string& LiveHttp::url() const {
  return impl_->url;
}
const std::string& LiveHttp::token() const {
  return impl_->token;
}
int LiveHttp::port() const {
  return impl_->port;
}

}  // namespace tenon::internal
