#include <tenon/systems/files/output_file.h>
#include <tenon/systems/live/internal/live_channel.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <iterator>
#include <thread>
#include <vector>

namespace tenon::internal::live_http_test {

using ::testing::HasSubstr, ::testing::Not;

/// A server without a run: a thread answers each command with its text.
class LiveHttpTest : public testing::Test {
 protected:
  LiveHttpTest() : client_("127.0.0.1", http_.port()) {
    run_ = std::thread([this] {
      while (!stop_) {
        channel_.WaitUntil(std::chrono::steady_clock::now() + std::chrono::milliseconds(20));
        while (auto request = channel_.TakeRequest())
          request->reply.set_value({200, "{\"heard\":" + request->json + "}"});
      }
    });
    http_.SetPage("<h1>page</h1>");
  }
  ~LiveHttpTest() override {
    stop_ = true;
    run_.join();
  }
  httplib::Result Post(const std::string& body, const httplib::Headers& headers = {},
                       const char* type = "application/json") {
    return client_.Post("/command?client=me", headers, body, type);
  }
  /// The stream of events up to `end`.
  std::string Listen(const std::string& end) {
    std::string all;
    httplib::Client client("127.0.0.1", http_.port());
    client.Get("/events?client=me", [&](const char* data, std::size_t size) {
      all.append(data, size);
      return all.find(end) == all.npos;
    });
    return all;
  }

  LiveChannel channel_{10};
  LiveHttp http_{"127.0.0.1", 0, channel_};
  httplib::Client client_;
  std::atomic<bool> stop_ = false;
  std::thread run_;
};

TEST_F(LiveHttpTest, ServesThePageAndCommands) {
  EXPECT_EQ(client_.Get("/")->body, "<h1>page</h1>");
  const auto answer = Post(R"({"command":"pause"})");
  EXPECT_EQ(answer->status, 200);
  EXPECT_EQ(answer->body, R"({"heard":{"command":"pause"}})");
  EXPECT_EQ(client_.Get("/else")->status, 404);
}

// The address is printed before the run is built.
TEST(LiveHttpStartTest, ThePageIsWaitedFor) {
  LiveChannel channel(10);
  LiveHttp http("127.0.0.1", 0, channel);
  std::atomic<bool> asked = false;
  std::thread browser([&] {
    httplib::Client client("127.0.0.1", http.port());
    asked = true;
    EXPECT_EQ(client.Get("/")->body, "<h1>page</h1>");
  });
  while (!asked) std::this_thread::yield();
  std::this_thread::yield();
  http.SetPage("<h1>page</h1>");
  browser.join();
}

TEST_F(LiveHttpTest, OtherOriginsAndHostsAreRefused) {
  const std::string own = "http://127.0.0.1:" + std::to_string(http_.port());
  EXPECT_EQ(Post("{}", {{"Origin", own}})->status, 200);
  const auto foreign = Post("{}", {{"Origin", "http://evil.example"}});
  EXPECT_EQ(foreign->status, 403);
  EXPECT_THAT(foreign->body, HasSubstr("evil.example"));
  EXPECT_EQ(Post("{}", {{"Host", "evil.example:8080"}})->status, 403);
  EXPECT_EQ(client_.Get("/events?client=me", {{"Host", "evil.example"}})->status, 403);
  EXPECT_EQ(channel_.refused(), 3);
}

// A browser says which relation a request has to the page that made it.
TEST_F(LiveHttpTest, RequestsOfPagesOfOtherSitesAreRefused) {
  const auto from = [&](const std::string& site, const std::string& mode, const std::string& dest) {
    return client_.Get("/", {{"Sec-Fetch-Site", site}, {"Sec-Fetch-Mode", mode}, {"Sec-Fetch-Dest", dest}})
        ->status;
  };
  EXPECT_EQ(from("none", "navigate", "document"), 200);
  EXPECT_EQ(from("same-origin", "navigate", "document"), 200);
  EXPECT_EQ(from("cross-site", "navigate", "document"), 200) << "a link to the page";
  EXPECT_EQ(from("cross-site", "navigate", "iframe"), 403);
  EXPECT_EQ(from("same-site", "navigate", "iframe"), 403) << "another port of this machine";
  EXPECT_EQ(from("cross-site", "no-cors", "image"), 403);
  for (const char* site : {"cross-site", "same-site"}) {
    EXPECT_EQ(client_.Get("/events?client=me", {{"Sec-Fetch-Site", site}})->status, 403);
    EXPECT_EQ(Post("{}", {{"Sec-Fetch-Site", site}})->status, 403);
    EXPECT_EQ(
        Post("{}", {{"Sec-Fetch-Site", site}, {"Sec-Fetch-Mode", "navigate"}, {"Sec-Fetch-Dest", "document"}})
            ->status,
        403)
        << "a form";
  }
}

TEST_F(LiveHttpTest, ThePageCannotBeFramed) {
  for (const char* path : {"/", "/else"}) {
    const auto answer = client_.Get(path);
    EXPECT_EQ(answer->get_header_value("Content-Security-Policy"), "frame-ancestors 'none'") << path;
    EXPECT_EQ(answer->get_header_value("X-Frame-Options"), "DENY") << path;
    EXPECT_EQ(answer->get_header_value("Cross-Origin-Opener-Policy"), "same-origin") << path;
  }
}

// Two servers in a row may each use another one of two headers.
TEST_F(LiveHttpTest, HeadersThatAreGivenTwiceAreRefused) {
  const std::string host = "127.0.0.1:" + std::to_string(http_.port());
  for (const auto& [name, value] : {std::pair<std::string, std::string>{"Host", host},
                                    {"Origin", "http://" + host},
                                    {"Sec-Fetch-Site", "same-origin"}}) {
    const auto answer = Post("{}", {{name, value}, {name, value}});
    EXPECT_EQ(answer->status, 400) << name;
    EXPECT_THAT(answer->body, HasSubstr(name));
  }
}

/// A connection that sends a part of a request.
class Incomplete {
 public:
  Incomplete(int port, const std::string& text) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof(to)), 0);
    EXPECT_EQ(::send(socket_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }
  ~Incomplete() { ::close(socket_); }
  Incomplete(const Incomplete&) = delete;
  Incomplete& operator=(const Incomplete&) = delete;

  /// Sends one byte at a time until the server ends the connection. Returns whether it does so in `within`.
  bool Drip(std::chrono::seconds within) const {
    const auto end = std::chrono::steady_clock::now() + within;
    while (std::chrono::steady_clock::now() < end) {
      if (::send(socket_, "a", 1, MSG_NOSIGNAL) != 1) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
  }

 private:
  int socket_;
};

std::ptrdiff_t OpenDescriptors() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

TEST_F(LiveHttpTest, IncompleteRequestsDoNotKeepThePageAway) {
  const std::ptrdiff_t before = OpenDescriptors();
  std::deque<Incomplete> others;
  for (int i = 0; i < 300; ++i)
    others.emplace_back(http_.port(), i % 3 == 0   ? ""
                                      : i % 3 == 1 ? "GET / HT"
                                                   : "POST /command?client=a HTTP/1.1\r\nHost: a\r\n"
                                                     "Content-Length: 60000\r\n\r\n{");
  client_.set_read_timeout(3);
  const auto page = client_.Get("/");
  ASSERT_TRUE(page);
  EXPECT_EQ(page->body, "<h1>page</h1>");
  EXPECT_LT(OpenDescriptors() - before, 300 + 80) << "the run needs descriptors for its files";
}

// 2,000 ranges of a page of 2 MB would be an answer of 4 GB, which ends the process if the memory ends.
TEST_F(LiveHttpTest, ARangeGivesTheWholePageOnce) {
  std::string ranges = "bytes=0-";
  for (int i = 0; i < 1500; ++i) ranges += ",0-";
  for (const std::string& range : {std::string("bytes=3-5"), ranges}) {
    const auto page = client_.Get("/", {{"Range", range}});
    ASSERT_TRUE(page);
    EXPECT_EQ(page->status, 200);
    EXPECT_EQ(page->body, "<h1>page</h1>");
  }
  channel_.Close();  // ends the stream
  const auto events = client_.Get("/events?client=me", {{"Range", ranges}});
  ASSERT_TRUE(events);
  EXPECT_EQ(events->status, 200) << "a browser refuses other statuses";
}

// 64 kB of gzip are up to 64 MB of text.
TEST_F(LiveHttpTest, CompressedCommandsAreRefused) {
  EXPECT_EQ(Post("{}", {{"Content-Encoding", "gzip"}})->status, 415);
}

TEST_F(LiveHttpTest, ARequestMustArriveInTime) {
  EXPECT_TRUE(Incomplete(http_.port(), "GET /").Drip(std::chrono::seconds(20)));
}

TEST_F(LiveHttpTest, BodiesAreChecked) {
  EXPECT_EQ(Post("{}", {}, "text/plain")->status, 415);
  EXPECT_EQ(Post(std::string(100000, ' '))->status, 413);
  EXPECT_EQ(client_.Post("/command", "{}", "application/json")->status, 400);
  EXPECT_EQ(client_.Post("/command?client=" + std::string(65, 'a'), "{}", "application/json")->status, 400);
}

TEST_F(LiveHttpTest, OtherMachinesNeedTheToken) {
  LiveChannel channel(10);
  LiveHttp http("0.0.0.0", 0, channel);
  http.SetPage("page");
  httplib::Client client("127.0.0.1", http.port());
  EXPECT_EQ(client.Get("/")->status, 403);
  EXPECT_EQ(client.Get("/?token=wrong")->status, 403);
  EXPECT_EQ(client.Get("/?token=" + http.token())->status, 200);
  EXPECT_THAT(http.url(), HasSubstr("?token=" + http.token()));
  EXPECT_EQ(http.token().size(), 32U);
}

// Browsers write an IPv6 address in brackets.
TEST(LiveHttpStartTest, AnIpv6AddressStandsInBrackets) {
  LiveChannel channel(10);
  std::optional<LiveHttp> http;
  try {
    http.emplace("::1", 0, channel);
  } catch (const OutputError& error) {
    GTEST_SKIP() << "this machine has no IPv6: " << error.what();
  }
  http->SetPage("page");
  const std::string host = "[::1]:" + std::to_string(http->port());
  EXPECT_EQ(http->url(), "http://" + host + "/?token=" + http->token());
  httplib::Client client("::1", http->port());
  const auto answer = client.Get("/?token=" + http->token(), {{"Host", host}, {"Origin", "http://" + host}});
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
}

TEST_F(LiveHttpTest, ATakenPortIsLeftForTheNext) {
  LiveChannel channel(10);
  EXPECT_GT(LiveHttp("127.0.0.1", http_.port(), channel).port(), http_.port());
}

TEST_F(LiveHttpTest, EventsComeInOrderAndLateOnesFromTheBeginning) {
  channel_.Begin(R"({"run":{}})", R"("names":["a"],"units":["m"])");
  channel_.Append(0.1, R"("time":[0.1],"values":[[1]])");
  channel_.Append(0.2, R"("time":[0.2],"values":[[2]])");
  channel_.SetStatus(R"({"time":0.2})");
  channel_.SetPull("{}");
  const std::string all = Listen("pull");
  EXPECT_EQ(all,
            "event: hello\ndata: {\"run\":{}}\n\n"
            "event: append\ndata: {\"names\":[\"a\"],\"units\":[\"m\"],\"time\":[0.1],\"values\":[[1]]}\n\n"
            "event: append\ndata: {\"time\":[0.2],\"values\":[[2]]}\n\n"
            "event: status\ndata: {\"time\":0.2}\n\n"
            "event: pull\ndata: {}\n\n");
  EXPECT_EQ(channel_.refused(), 0);
}

TEST_F(LiveHttpTest, WhatIsOldIsForgotten) {
  channel_.Begin("{}", "\"names\":[]");
  for (int i = 0; i <= 30; ++i) channel_.Append(i, "\"n\":" + std::to_string(i));
  channel_.SetStatus("{}");
  const std::string all = Listen("status");
  EXPECT_THAT(all, Not(HasSubstr("\"n\":19}")));
  EXPECT_THAT(all, HasSubstr("{\"names\":[],\"n\":20}"));
}

TEST(LiveChannel, AReaderThatFallsBehindBeginsAnew) {
  LiveChannel channel(10);
  LiveChannel::Reader reader(channel, "slow");
  channel.Begin("{}", "\"names\":[]");
  channel.Append(0, "\"n\":0");
  EXPECT_THAT(reader.Next(), HasSubstr("\"n\":0"));
  for (int i = 1; i <= 30; ++i) channel.Append(i, "\"n\":" + std::to_string(i));
  EXPECT_THAT(reader.Next(),
              testing::StartsWith("event: reset\ndata: {}\n\nevent: append\ndata: {\"names\":[],\"n\":20}"));
}

TEST(LiveChannel, AClientIsThereAsLongAsItListens) {
  LiveChannel channel(10);
  {
    const LiveChannel::Reader first(channel, "me"), second(channel, "me");
    EXPECT_EQ(channel.clients(), 2U);
    EXPECT_TRUE(channel.IsConnected("me"));
  }
  EXPECT_FALSE(channel.IsConnected("me"));
}

}  // namespace tenon::internal::live_http_test
