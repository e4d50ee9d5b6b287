// The page of a live run in a browser, and how it controls the run.

#include <tenon/tests/apps/common/live_app.h>
#include <tenon/tests/systems/report/page_layout.h>

#include <chrono>

namespace tenon::test::live_browser_test {

using testing::Browser, ::testing::HasSubstr, ::testing::IsEmpty;

constexpr auto kPatience = std::chrono::seconds(90);  // reached only by a run that hangs

struct LiveBrowserTest : LiveAppTest {
  void SetUp() override { testing::RequireBrowser(); }
  bool Until(const std::string& expression) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
      if (browser.Evaluate("new Promise((done) => setTimeout(() => done(!!(" + expression + ")), 20))") ==
          true)
        return true;
    }
    return false;
  }
  static std::string Newest(const std::string& signal) {
    return "tenonReport.runs[0].find('" + signal + "')[0].values.at(-1)";
  }
  static std::string ButtonOf(const std::string& box, const std::string& text) {
    return "[...document.querySelectorAll('" + box + " button')].find((b) => b.textContent === '" + text +
           "')";
  }
  Browser browser;
};

TEST_F(LiveBrowserTest, AllOfThePageCanBeSeen) {
  Start(std::string(TENON_QUADRUPED) + " flat --live" + Out());
  browser.Navigate(address);
  ASSERT_TRUE(Until("!!window.tenonReport && tenonReport.ready")) << Json(browser.complaints());
  ASSERT_TRUE(Until("tenonReport.live.drives"));
  browser.Press(" ");
  ASSERT_TRUE(Until("tenonReport.live.status.state === 'paused'"));
  EXPECT_THAT(testing::LayoutFaults(browser), IsEmpty());
  browser.Evaluate(ButtonOf("#run-bar", "stop") + ".click()");
  browser.Evaluate(ButtonOf("#run-bar", "really stop?") + ".click()");
  EXPECT_EQ(End(), 130);  // like after Ctrl-C
}

TEST_F(LiveBrowserTest, TheRobotIsDrivenPushedTunedSetBackAndReplayed) {
  Start(std::string(TENON_QUADRUPED) + " flat --live" + Out());
  browser.Resize(1000, 600);
  browser.Navigate(address);
  ASSERT_TRUE(Until("!!window.tenonReport && tenonReport.ready")) << Json(browser.complaints());
  browser.Evaluate(
      "tenonReport.replay.simplify(), tenonReport.replay.simplify()");  // tests have no graphics card
  ASSERT_TRUE(Until("tenonReport.live.drives"));

  // A metre forward.
  const std::string forward = Newest("loop.world.plant.state.p_WB.x");
  const double start = browser.Evaluate(forward);
  browser.Key("rawKeyDown", "W", true);
  EXPECT_TRUE(Until(forward + " > " + std::to_string(start + 1)));
  browser.Key("keyUp", "W");
  browser.Evaluate(ButtonOf("#drive", "stand") + ".click()");
  EXPECT_TRUE(
      Until("['x', 'y', 'z'].every((k) => Math.abs(tenonReport.runs[0].find("
            "'loop.world.plant.state.v_W.' + k)[0].values.slice(-50).reduce((a, b) => Math.max(a, "
            "Math.abs(b)))) < 0.005)"))
      << "it stands still";

  // 40 N to the side of the picture, at the point that is clicked: the middle of the trunk on the screen.
  browser.Press(" ");
  ASSERT_TRUE(Until("tenonReport.live.status.state === 'paused'"));
  browser.Evaluate("tenonReport.replay.render()");
  const auto on_screen = [&](const std::string& point) {
    return browser.Evaluate(
        "(() => { const {camera, renderer, runs} = tenonReport.replay, box = "
        "renderer.domElement.getBoundingClientRect(), {x, y} = " +
        point +
        ".project(camera); return [box.left + box.width * (1 + x) / 2, box.top + "
        "box.height * (1 - y) / 2]; })()");
  };
  const Json press = on_screen("runs[0].actors[0].object.position.clone()");
  browser.Mouse("mousePressed", press[0], press[1]);
  ASSERT_TRUE(Until("!document.querySelector('#force').hidden"));
  const Json clicked = on_screen("tenonReport.grab.held.point.clone()");
  EXPECT_NEAR(clicked[0], press[0], 1);
  EXPECT_NEAR(clicked[1], press[1], 1);
  const Json target = on_screen(
      "tenonReport.grab.held.point.clone().add(new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, "
      "0).multiplyScalar(40 / tenonReport.live.controls.pull.stiffness_N_per_m))");
  browser.Mouse("mouseMoved", target[0], target[1]);
  ASSERT_TRUE(Until("/^(3[6-9]|4[0-4]) N at trunk$/.test(document.querySelector('#force').textContent)"))
      << browser.Evaluate("document.querySelector('#force').textContent");
  browser.Press(".");
  const std::string pull =
      "Math.hypot(...['x', 'y', 'z'].map((k) => tenonReport.runs[0].find("
      "'live_pull.force.force_W.' + k)[0].values.at(-1)))";
  EXPECT_TRUE(Until("Math.abs(" + pull + " - 40) < 8")) << browser.Evaluate(pull);
  browser.Press(" ");
  ASSERT_TRUE(Until("tenonReport.live.status.state === 'running'"));
  browser.Mouse("mouseReleased", target[0], target[1]);
  EXPECT_TRUE(Until(pull + " === 0"));

  // A gain.
  browser.Evaluate(
      "(() => { const find = document.querySelector('#tune input[type=search]'); find.value = "
      "'com_planner.blend'; find.dispatchEvent(new Event('input')); })()");
  browser.Evaluate(
      "(() => { const field = document.querySelector('#tune .parameter:not([hidden]) input[type=number]'); "
      "field.value = 0.4; field.dispatchEvent(new Event('change')); })()");
  EXPECT_TRUE(Until(
      "tenonReport.live.parameters.some(({path, now}) => path === 'loop.locomotion.com_planner.blend' && "
      "now && now[0] === 0.4)"));

  // Back, and on from there.
  const double before = browser.Evaluate("tenonReport.runs[0].end");
  browser.Press("b");
  EXPECT_TRUE(Until("tenonReport.runs[0].end < " + std::to_string(before - 3)));
  EXPECT_TRUE(Until("tenonReport.runs[0].end > " + std::to_string(before - 2)));

  browser.Evaluate(ButtonOf("#run-bar", "stop") + ".click()");
  browser.Evaluate(ButtonOf("#run-bar", "really stop?") + ".click()");
  EXPECT_EQ(End(), 130);  // like after Ctrl-C
  ExpectSameReplay(TENON_QUADRUPED " flat");
}

}  // namespace tenon::test::live_browser_test
