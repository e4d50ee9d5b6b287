// The page of a live run, with a server in place of the run.

#include <tenon/systems/report/internal/report_json.h>
#include <tenon/tests/systems/report/page_layout.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/temporary_path.h>

#include <httplib.h>

#include <condition_variable>
#include <mutex>
#include <thread>

namespace tenon::live_page_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using ::testing::Each, ::testing::HasSubstr, ::testing::IsEmpty;

constexpr auto kPatience = std::chrono::seconds(60);  // only a page that hangs takes so long

/// A server in place of a run: sends messages of the test to every client, and keeps the commands of the
/// clients. Refuses negative parameters.
class FakeRun {
 public:
  FakeRun() {
    server_.Get("/", [](const httplib::Request&, httplib::Response& response) {
      const fs::path file = test::TemporaryPath("tenon_live_page.html");
      const Json data{
          {"format", internal::kPageFormat}, {"title", "workshop"},   {"description", ""},
          {"plots", Json::array()},          {"runs", Json::array()}, {"live", {{"token", "open sesame"}}}};
      internal::WritePage(file, "workshop", data.dump());
      response.set_content(ReadText(file), "text/html");
      fs::remove(file);
    });
    server_.Get("/events", [this](const httplib::Request& request, httplib::Response& response) {
      EXPECT_EQ(request.get_param_value("token"), "open sesame");
      const std::lock_guard lock(mutex_);
      client_ = request.get_param_value("client");
      const int connection = ++connection_;
      pending_ = greeting_;
      response.set_chunked_content_provider(
          "text/event-stream", [this, connection](std::size_t, httplib::DataSink& sink) {
            std::unique_lock wait(mutex_);
            changed_.wait(wait, [&] { return connection != connection_ || stopped_ || !pending_.empty(); });
            if (stopped_ || connection != connection_) return false;
            const std::string message = pending_.front();
            pending_.pop_front();
            wait.unlock();
            return sink.write(message.data(), message.size());
          });
    });
    server_.Post("/command", [this](const httplib::Request& request, httplib::Response& response) {
      EXPECT_EQ(request.get_param_value("token"), "open sesame");
      EXPECT_EQ(request.get_header_value("Content-Type"), "application/json");
      const Json command = Json::parse(request.body);
      Json answer{{"ok", true}};
      if (command["command"] == "save") answer["yaml"] = "duration_s: 3\n";
      if (command["command"] == "parameter" && command["value"] < 0) {
        answer = {{"error", "stiffness must be at least 0"}};
        response.status = 400;
      }
      response.set_content(answer.dump(), "application/json");
      const std::lock_guard lock(mutex_);
      commands_.push_back(command);
      changed_.notify_all();
    });
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
  }
  ~FakeRun() {
    {
      const std::lock_guard lock(mutex_);
      stopped_ = true;
      changed_.notify_all();
    }
    server_.stop();
    thread_.join();
  }

  std::string address() const { return "http://127.0.0.1:" + std::to_string(port_); }
  std::string client() {
    const std::lock_guard lock(mutex_);
    return client_;
  }

  void Send(const std::string& name, const Json& data) {
    const std::lock_guard lock(mutex_);
    pending_.push_back(Message(name, data));
    changed_.notify_all();
  }
  /// Sets the first messages to every client.
  void Greet(const Json& hello, const Json& append) {
    const std::lock_guard lock(mutex_);
    greeting_ = {"retry: 10\n" + Message("hello", hello), Message("append", append)};
  }
  void Disconnect() {
    const std::lock_guard lock(mutex_);
    ++connection_;
    changed_.notify_all();
  }
  /// The next command of this name, which may have come already; null if it does not come.
  Json Await(const std::string& name) {
    std::unique_lock lock(mutex_);
    Json found;
    changed_.wait_for(lock, kPatience, [&] {
      while (!commands_.empty() && found.is_null()) {
        if (commands_.front()["command"] == name) found = commands_.front();
        commands_.pop_front();
      }
      return !found.is_null();
    });
    return found;
  }
  std::size_t num_commands() {
    const std::lock_guard lock(mutex_);
    return commands_.size();
  }

 private:
  static std::string Message(const std::string& name, const Json& data) {
    return "event: " + name + "\ndata: " + data.dump() + "\n\n";
  }

  httplib::Server server_;
  std::thread thread_;
  int port_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> greeting_, pending_;
  std::deque<Json> commands_;
  std::string client_;
  int connection_ = 0;
  bool stopped_ = false;
};

Json Shape(const char* kind, const char* role, const char* name) {
  return {{"kind", kind}, {"role", role}, {"name", name}, {"size", {0.4, 0.2, 0.1}},
          {"scale", 1},   {"unit", ""}};
}

Json Hello() {
  return {{"run",
           {{"name", "flat"},
            {"shapes", {Shape("box", "bodies", "trunk"), Shape("trace", "estimates", "path")}},
            {"bands", {{{"signal", "loop.mode"}, {"names", {"walk", "stand"}}}}},
            {"limits", Json::array()},
            {"plots",
             {{{"title", "force"},
               {"group", ""},
               {"signals", {"loop.force", "loop.mode"}},
               {"references", Json::array()}}}},
            {"figures", Json::array()}}},
          {"description", "on flat ground"},
          {"controls",
           {{"drive", {{"forward", {-0.5, 0.8}}, {"sideways", {-0.4, 0.4}}, {"yaw", {-1, 1}}}},
            {"gaits", {"trot", "walk"}},
            {"pull", {{"stiffness_N_per_m", 500}, {"max_N", 200}, {"bodies", {{"0", "trunk"}}}}},
            {"load", {{"name", "trunk load"}, {"mass_kg", {0, 10}}, {"start", 3}}}}},
          {"parameters",
           {{{"path", "loop.pd.stiffness"},
             {"value", 100},
             {"elements", Json::array()},
             {"unit", "N/m"},
             {"ranges",
              {{{"low", 0}, {"high", nullptr}, {"above", true}, {"below", true}, {"text", "above 0 N/m"}}}},
             {"meaning", "of the spring"}}}},
          {"history_s", 30}};
}

/// Samples every 10 ms in (from, to]: a force of 0 with one sample of 7 N at `peak`, a mode that is 0 up to 1
/// s and 1 afterwards, and a trunk that moves along x at 1 m/s.
Json Samples(double from, double to, double peak = -1) {
  Json time = Json::array(), force = Json::array(), mode = Json::array();
  for (int i = static_cast<int>(from * 100 + 0.5) + 1; i <= static_cast<int>(to * 100 + 0.5); ++i) {
    time.push_back(i / 100.0);
    force.push_back(std::abs(i / 100.0 - peak) < 1e-6 ? 7 : 0);
    mode.push_back(i > 100);
  }
  for (Json& value : mode) value = value == true ? 1 : 0;
  const Json still{0, 0, 0.3, 1, 0, 0, 0, 0, 0, 0, 0, 1};
  Json columns = Json::array();
  for (int shape = 0; shape < 2; ++shape) {
    for (const Json& value : still) columns.push_back(value);
    columns[columns.size() - 12] = Json::array({from, to});
  }
  return {{"names", {"loop.force", "loop.mode"}},
          {"units", {"N", ""}},
          {"time", time},
          {"values", {force, mode}},
          {"frames", {{"time", {from, to}}, {"columns", columns}}}};
}

struct LivePageTest : testing::BrowserTest {
  void Load() {
    run.Greet(Hello(), Samples(0, 1));
    browser.Resize(1000, 600);
    browser.Navigate(run.address());
    ASSERT_TRUE(Until("!!window.tenonReport && tenonReport.ready")) << Json(browser.complaints());
    Js("tenonReport.replay.simplify(), tenonReport.replay.simplify()");  // tests have no graphics card
  }
  void Open() {
    Load();
    Status(run.client());
    ASSERT_TRUE(Until("tenonReport.live.drives"));
  }
  void Status(const std::string& driver, const std::string& state = "running") {
    run.Send("status", {{"time", 1}, {"state", state}, {"rate_wanted", 1}, {"rate", 1}, {"driver", driver}});
  }
  /// Waits for an expression to become true.
  bool Until(const std::string& expression) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
      if (Js("new Promise((done) => setTimeout(() => done(!!(" + expression + ")), 5))") == true) return true;
    }
    return false;
  }
  std::string Text(const std::string& selector) {
    return Js("document.querySelector('" + selector + "').textContent");
  }

  FakeRun run;
};

TEST_F(LivePageTest, FollowsScrubsAndIsSetBack) {
  Load();
  Status("");
  EXPECT_EQ(run.Await("take"), Json({{"command", "take"}})) << "nobody drove";
  Status(run.client());
  ASSERT_TRUE(Until("tenonReport.live.drives"));
  EXPECT_EQ(Text("#headline p"), "on flat ground");
  EXPECT_THAT(Text("#run-bar"), HasSubstrs("running at 1.00×", "you drive"));

  // The plots show the newest samples in a moving window, thinned but with every peak.
  run.Send("append", Samples(1, 41, 35.01));
  ASSERT_TRUE(Until("tenonReport.time() === 41"));
  EXPECT_EQ(Js("tenonReport.plots.window"), Json({31, 41}));
  Js("tenonReport.follower.span = 30, tenonReport.follower.join()");
  ASSERT_TRUE(Until("tenonReport.plots.plots[0].graph.xAxisRange()[0] === 11"));
  EXPECT_LT(Js("tenonReport.plots.plots[0].graph.numRows()").get<int>(), 900) << "of 3000";
  EXPECT_EQ(Js("Math.max(...tenonReport.plots.plots[0].graph.rawData_.map((row) => row[1]))"), 7);
  // Curves keep their colours, however noisy they turn out to be.
  EXPECT_EQ(Js("(() => { const p = tenonReport.plots.plots[0]; p.series[1].noise = 9; p.measured = "
               "performance.now(); p.update(p.measured); return p.graph.rawData_.at(-1); })()"),
            Json({41, 0, 1}));
  EXPECT_NEAR(Js("tenonReport.replay.runs[0].actors[0].object.position.x").get<double>(), 41, 1e-5);
  EXPECT_EQ(
      Js("tenonReport.runs[0].bands[0].intervals"),
      Json::parse(
          R"([{"time": 0.01, "value": 0, "name": "walk"}, {"time": 1.01, "value": 1, "name": "stand"}])"));

  // A page that shows the past stays there until the button is pressed.
  Js("tenonReport.seek(40)");
  run.Send("append", Samples(41, 42));
  ASSERT_TRUE(Until("tenonReport.duration() === 42"));
  EXPECT_EQ(Js("[tenonReport.time(), document.querySelector('#live').ariaPressed]"), Json({40, "false"}));
  EXPECT_EQ(Js("tenonReport.plots.window"), Json({11, 41}));

  // The run is set back to the time that is shown.
  const std::string back =
      "[...document.querySelectorAll('#transport button')].find((b) => b.textContent === 'back to 40.00 s')";
  ASSERT_TRUE(Until(back));
  Js(back + ".click()");
  EXPECT_EQ(run.Await("back"), Json({{"command", "back"}, {"to_s", 40}}));
  run.Send("back", {{"to_s", 40}});
  Status(run.client(), "paused");
  ASSERT_TRUE(Until("tenonReport.live.status.state === 'paused' && tenonReport.time() === 40"));
  EXPECT_EQ(Js("tenonReport.runs[0].find('loop.force')[0].time.at(-1)"), 40);
  EXPECT_EQ(Js("tenonReport.runs[0].frames.time.at(-1)"), 1) << "the next was at 41 s";
  browser.Press(" ");
  EXPECT_EQ(run.Await("resume")["command"], "resume");

  // Old samples are dropped.
  for (int t = 40; t < 220; t += 20) run.Send("append", Samples(t, t + 20));
  ASSERT_TRUE(Until("tenonReport.time() === 220"));
  EXPECT_GT(Js("tenonReport.runs[0].start").get<double>(), 60);
  EXPECT_LT(Js("tenonReport.runs[0].find('loop.force')[0].time.length").get<int>(), 15100);
  EXPECT_EQ(Js("tenonReport.runs[0].find('loop.force')[0].values.length === "
               "tenonReport.runs[0].find('loop.force')[0].time.length"),
            true);

  // JSON has no numbers that are not finite: they arrive as null.
  run.Send("append", {{"time", {220.5}}, {"values", {{nullptr}, {1}}}});
  ASSERT_TRUE(Until("tenonReport.time() === 220.5"));
  EXPECT_EQ(Js("Number.isNaN(tenonReport.runs[0].find('loop.force')[0].values.at(-1))"), true);

  // A run that a monitor ended can be set back.
  run.Send("status", {{"time", 220},
                      {"state", "ended"},
                      {"rate_wanted", 1},
                      {"rate", 0},
                      {"driver", run.client()},
                      {"end_reason", "it fell"}});
  ASSERT_TRUE(Until("tenonReport.live.ended"));
  EXPECT_EQ(Text("#run-bar .verdict"), "ended: it fell");
  browser.Press("b");
  EXPECT_EQ(run.Await("back"), Json({{"command", "back"}, {"to_s", 215.5}}));
  Status(run.client());
  ASSERT_TRUE(Until("!tenonReport.live.ended"));

  // After a lost connection the page loads everything again.
  Js("window.texts = new Set(); new MutationObserver(() => texts.add(document.querySelector('#run-bar "
     ".verdict').textContent)).observe(document.querySelector('#run-bar'), {childList: true, subtree: "
     "true})");
  run.Greet(Hello(), Samples(300, 301));
  run.Disconnect();
  ASSERT_TRUE(Until("tenonReport.time() === 301"));
  EXPECT_EQ(Js("texts.has('connection lost, trying again …')"), true);
  EXPECT_EQ(Js("tenonReport.runs[0].start"), 300);
  EXPECT_THAT(browser.complaints(), Each(HasSubstr("ERR_INCOMPLETE_CHUNKED_ENCODING")))
      << "the lost connection alone";
  EXPECT_THAT(browser.requests(), Each(HasSubstr(run.address())));
}

TEST_F(LivePageTest, DrivesPullsAndTunes) {
  Open();
  browser.Key("rawKeyDown", "w");
  EXPECT_EQ(run.Await("drive")["velocity"], Json({0.4, 0, 0}));
  browser.Key("rawKeyDown", "Q", true);
  EXPECT_EQ(run.Await("drive")["velocity"], Json({0.4, 0, 1})) << "faster with shift";
  browser.Key("keyUp", "Q");
  EXPECT_EQ(run.Await("drive")["velocity"], Json({0.4, 0, 0}));
  browser.Key("keyUp", "w");
  EXPECT_EQ(run.Await("drive")["velocity"], Json({0, 0, 0}));
  // The stick, to the left and back; a gamepad.
  const auto middle = [&](const std::string& selector) {
    return Js("(() => { const b = document.querySelector('" + selector +
              "').getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; })()");
  };
  const Json stick = middle(".stick");
  browser.Mouse("mousePressed", stick[0], stick[1]);
  browser.Mouse("mouseMoved", stick[0].get<double>() - 300, stick[1]);
  EXPECT_EQ(run.Await("drive")["velocity"], Json({0, 0.4, 0}));
  browser.Mouse("mouseReleased", stick[0], stick[1]);
  EXPECT_EQ(run.Await("drive")["velocity"], Json({0, 0, 0}));
  Js("navigator.getGamepads = () => [null, {axes: [0, 1, 0, 0]}], 0");
  EXPECT_EQ(run.Await("drive")["velocity"], Json({-0.5, 0, 0}));
  Js("navigator.getGamepads = () => [], 0");
  EXPECT_EQ(run.Await("drive")["velocity"], Json({0, 0, 0}));
  Js("[...document.querySelectorAll('#drive button')].find((b) => b.textContent === 'walk').click()");
  EXPECT_EQ(run.Await("gait")["name"], "walk");
  Js("[...document.querySelectorAll('#drive button')].find((b) => b.textContent === 'drop').click()");
  EXPECT_EQ(run.Await("load")["mass_kg"], 3);

  // The trunk stands in the middle of its box on the screen.
  Js("tenonReport.replay.render()");
  const Json trunk = Js(R"((() => {
    const {camera, renderer, runs} = tenonReport.replay, box = renderer.domElement.getBoundingClientRect();
    const {x, y} = runs[0].actors[0].object.position.clone().project(camera);
    return [box.left + box.width * (1 + x) / 2, box.top + box.height * (1 - y) / 2];
  })())");
  browser.Mouse("mousePressed", trunk[0], trunk[1]);
  const Json at_first = run.Await("pull");
  EXPECT_EQ(at_first["shape"], 0);
  EXPECT_EQ(at_first["point_W"], at_first["target_W"]);
  browser.Mouse("mouseMoved", trunk[0].get<double>() + 40, trunk[1].get<double>() - 60);
  const Json pull = run.Await("pull");
  EXPECT_EQ(pull["point_W"], at_first["point_W"]);
  EXPECT_GT(pull["target_W"][2], pull["point_W"][2]) << "up";
  const std::string from_camera =
      "tenonReport.replay.camera.getWorldDirection(new THREE.Vector3()).dot(new THREE.Vector3(...";
  EXPECT_NEAR(Js(from_camera + pull["point_W"].dump() + "))").get<double>(),
              Js(from_camera + pull["target_W"].dump() + "))").get<double>(), 1e-4)
      << "in the plane that faces the camera";
  run.Send("pull",
           {{"body", "trunk"}, {"point_W", {1, 0, 0.3}}, {"target_W", {1, 0, 0.7}}, {"force_N", 123.4}});
  ASSERT_TRUE(Until("!document.querySelector('#force').hidden"));
  EXPECT_EQ(Text("#force"), "123 N at trunk");
  EXPECT_EQ(Js("[tenonReport.grab.arrow.object.visible, tenonReport.grab.arrow.object.position.x]"),
            Json({true, 1}));
  browser.Mouse("mouseReleased", trunk[0], trunk[1]);
  EXPECT_EQ(run.Await("release")["command"], "release");
  run.Send("pull", Json::object());
  ASSERT_TRUE(Until("document.querySelector('#force').hidden && !tenonReport.grab.arrow.object.visible"));

  // A refused value is reset, and the reason is shown.
  const auto enter = [&](const std::string& selector, const std::string& value, const std::string& event) {
    Js("(() => { const field = document.querySelector('" + selector + "'); field.value = '" + value +
       "'; field.dispatchEvent(new Event('" + event + "')); })()");
  };
  enter("#tune input[type=search]", "spring", "input");
  EXPECT_EQ(Text("#tune .head small"), "above 0 N/m");
  EXPECT_EQ(Js("(({min, max}) => [min, max])(document.querySelector('#tune input[type=range]'))"),
            Json({"0.2", "200"}))
      << "the open end is approached";
  enter("#tune input[type=number]", "-5", "change");
  EXPECT_EQ(run.Await("parameter"),
            Json::parse(R"({"command": "parameter", "path": "loop.pd.stiffness", "value": -5})"));
  ASSERT_TRUE(Until("document.querySelector('.refusal').textContent"));
  EXPECT_THAT(Text(".refusal"), HasSubstr("stiffness"));
  EXPECT_EQ(Js("document.querySelector('#tune input[type=number]').value"), "100");
  enter("#tune input[type=range]", "150", "input");
  EXPECT_EQ(run.Await("parameter")["value"], 150);
  run.Send("parameter", {{"path", "loop.pd.stiffness"}, {"value", 140}});
  ASSERT_TRUE(Until("document.querySelector('#tune input[type=number]').value === '140'"));
  EXPECT_TRUE(Until("document.querySelector('.refusal').textContent === ''"));

  Js("HTMLAnchorElement.prototype.click = function() { window.saved = this.download; }, 0");
  Js("tenonReport.follower.join(), [...document.querySelectorAll('#run-bar button')].find((b) => "
     "b.textContent === 'save scenario').click()");
  ASSERT_TRUE(Until("window.saved"));
  EXPECT_EQ(Js("saved"), "scenario.yaml");

  EXPECT_EQ(testing::UnnamedControls(browser), Json::array());

  // While another browser drives, this page only shows the run.
  Status("another");
  ASSERT_TRUE(Until("!tenonReport.live.drives"));
  run.Await("save");
  EXPECT_THAT(Text("#run-bar"), HasSubstrs("another browser drives", "take over"));
  EXPECT_EQ(Js("[...document.querySelectorAll('#run-bar fieldset, #drive fieldset, #tune "
               "fieldset')].every((f) => f.disabled)"),
            true);
  browser.Press("w");
  browser.Mouse("mousePressed", trunk[0], trunk[1]);
  browser.Mouse("mouseReleased", trunk[0], trunk[1]);
  Js("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))");
  EXPECT_EQ(run.num_commands(), 0U);
  for (const int width : {400, 1000, 1800}) {
    browser.Resize(width, 800);
    EXPECT_LE(
        Js("new Promise((done) => requestAnimationFrame(() => done(document.documentElement.scrollWidth)))")
            .get<int>(),
        width)
        << "no scrolling sideways";
  }
  EXPECT_THAT(browser.complaints(), Each(HasSubstr("400 (Bad Request)"))) << "what was refused alone";
}

}  // namespace tenon::live_page_test
