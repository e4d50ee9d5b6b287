// A page of another site that tries to control a live run.

#include <tenon/systems/live/internal/live_channel.h>
#include <tenon/tests/systems/report/browser.h>

#include <gmock/gmock.h>
#include <httplib.h>

#include <atomic>
#include <thread>

namespace tenon::internal::hostile_page_test {

using testing::Browser, ::testing::ElementsAre;

/// A live server whose page sends a command while it is loaded, and the server of another site.
class HostilePageTest : public testing::BrowserTest {
 protected:
  HostilePageTest() {
    run_ = std::thread([this] {
      while (!stop_) {
        channel_.WaitUntil(std::chrono::steady_clock::now() + std::chrono::milliseconds(20));
        while (auto request = channel_.TakeRequest()) {
          request->reply.set_value({});
          const std::lock_guard lock(mutex_);
          heard_.push_back(request->json);
        }
      }
    });
    http_.SetPage(
        "<script>const request = new XMLHttpRequest(); request.open('POST', '/command?client=page', false); "
        "request.setRequestHeader('Content-Type', 'application/json'); request.send('the page');</script>");
    other_.Get("/", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content("<body></body><script>const live = '" + live() + "';</script>", "text/html");
    });
    other_port_ = other_.bind_to_any_port("127.0.0.1");
    serving_ = std::thread([this] { other_.listen_after_bind(); });
    while (!other_.is_running()) std::this_thread::yield();
  }
  ~HostilePageTest() override {
    stop_ = true;
    other_.stop();
    run_.join();
    serving_.join();
  }
  std::string live() const { return "http://127.0.0.1:" + std::to_string(http_.port()) + "/"; }
  std::vector<std::string> heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }

  LiveChannel channel_{10};
  LiveHttp http_{"127.0.0.1", 0, channel_};
  httplib::Server other_;
  int other_port_ = 0;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;
  std::vector<std::string> heard_;
  std::thread run_, serving_;
};

TEST_F(HostilePageTest, CanNeitherFrameNorControlTheRun) {
  Browser browser({"--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1, EXCLUDE localhost"});
  browser.Navigate(live());
  ASSERT_THAT(heard(), ElementsAre("the page")) << "the page itself works";
  // Another port of the same name is the same site, and another name is another site.
  for (const std::string host : {"127.0.0.1", "localhost"}) {
    browser.Navigate("http://" + host + ":" + std::to_string(other_port_) + "/");
    const std::string loaded =
        "(tag, from) => new Promise((done) => { const element = document.createElement(tag); element.onload "
        "= "
        "element.onerror = done; element[tag === 'object' ? 'data' : 'src'] = from; "
        "document.body.append(element); })";
    for (const std::string tag : {"iframe", "object", "embed"})
      browser.Evaluate("(" + loaded + ")('" + tag + "', live).then(() => 0)");
    browser.Evaluate("(" + loaded + ")('img', live + 'events?client=page').then(() => 0)");
    for (const std::string type : {"text/plain", "application/json"})
      browser.Evaluate("fetch(live + 'command?client=page', {method: 'POST', mode: '" +
                       std::string(type == "text/plain" ? "no-cors" : "cors") +
                       "', headers: {'Content-Type': '" + type +
                       "'}, body: 'fetched'}).then(() => 0, () => 1)");
    browser.Evaluate(
        "new Promise((done) => { const frame = document.createElement('iframe'); frame.name = 'answer'; "
        "document.body.append(frame); frame.onload = done; const form = document.createElement('form'); "
        "form.method = 'post'; form.enctype = 'text/plain'; form.target = 'answer'; form.action = live + "
        "'command?client=page'; document.body.append(form); form.submit(); }).then(() => 0)");
  }
  EXPECT_THAT(heard(), ElementsAre("the page"));
  EXPECT_EQ(channel_.clients(), 0U);
}

}  // namespace tenon::internal::hostile_page_test
