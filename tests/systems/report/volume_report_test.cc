#include <tenon/systems/report/volume_report.h>
#include <tenon/tests/systems/report/page_layout.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::volume_report_test {

using ::testing::Each, ::testing::IsEmpty, ::testing::StartsWith;
using State = VolumeReport::State;

/// A box of 4 x 3 x 2 cells: a block of 2 x 2 x 2 cells holds, one beside it is undecided, the rest fails.
VolumeReport Example() {
  VolumeReport::Map map{.title = "places",
                        .coordinates = {"x_m", "y_m", "z_m"},
                        .low = {-2, 0, 1},
                        .high = {2, 3, 2},
                        .cells = {4, 3, 2},
                        .quantities = {"margin_N", "stiffness_N_per_m"},
                        .parts = {{{0, 0, 0}, {2, 2, 2}, State::kHolds, {5, 100}},
                                  {{2, 0, 0}, {1, 1, 1}, State::kUndecided, {1, test::kNan}},
                                  {{2, 0, 1}, {1, 1, 1}, State::kFails, {-1, test::kNan}},
                                  {{3, 0, 0}, {1, 1, 2}, State::kFails, {-2, test::kNan}},
                                  {{2, 1, 0}, {2, 1, 2}, State::kFails, {-2, test::kNan}},
                                  {{0, 2, 0}, {4, 1, 2}, State::kFails, {-3, test::kNan}}},
                        .shapes = {Shape::Box(ShapeRole::kBody, "body", {0.5, 0.5, 0.5})}};
  VolumeReport::Map other = map;
  other.title = "turns";
  other.shapes.clear();
  return {.title = "box </script> & more",
          .description = "four by three by two",
          .figures = {{"volume_m3", 8.0}, {"nothing_N", std::nullopt}},
          .maps = {map, other}};
}

struct VolumeReportTest : testing::BrowserTest {
  ~VolumeReportTest() override { std::filesystem::remove(file); }
  const std::filesystem::path file = test::TemporaryPath("tenon_volume_report.html");
};

TEST_F(VolumeReportTest, PageShowsCellsSlicesAndTheirSurface) {
  Example().Write(file);
  browser.Open(file);
  ASSERT_EQ(Js("!!window.tenonVolume && tenonVolume.ready"), true)
      << nlohmann::json(browser.complaints()).dump();
  EXPECT_EQ(Js("document.querySelector('h1').textContent"), "box </script> & more");
  EXPECT_EQ(Js("[...document.querySelectorAll('#figures td')].map((cell) => cell.textContent)"),
            nlohmann::json({"8", "m³", "–", "N"}));
  EXPECT_EQ(Js("[tenonVolume.state(1, 1, 1), tenonVolume.state(2, 0, 0), tenonVolume.state(2, 0, 1)]"),
            nlohmann::json({2, 1, 0}));
  EXPECT_EQ(Js("document.querySelectorAll('#slices canvas').length"), 3);

  // The colour of a cell in the slice across z: what holds is coloured, what fails is white.
  const nlohmann::json colours = Js(R"((() => {
    const canvas = document.querySelector('#slices canvas'), width = parseFloat(canvas.style.width);
    const ratio = canvas.width / width, scale = Math.min((width - 56) / 4, 100);
    const pixels = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return [[3.5, 0.5], [0.5, 2.5]].map(([x, y]) => {
      const at = 4 * (Math.floor((6 + scale * y) * ratio) * canvas.width + Math.floor((46 + scale * x) * ratio));
      return [...pixels.data.slice(at, at + 3)].join();
    });
  })())");
  EXPECT_EQ(colours[0], "255,255,255");
  EXPECT_NE(colours[1], "255,255,255");

  // A block of 2 x 2 x 2 cells has 24 faces of cells.
  if (Js("tenonVolume.webgl") == true) {
    EXPECT_EQ(Js("tenonVolume.faces"), 24);
    EXPECT_EQ(Js("tenonVolume.replay.runs[0].group.children.filter((c) => c.isMesh).length"), 1);
  }
  Js("tenonVolume.colour(1)");
  Js("tenonVolume.show(1)");
  EXPECT_EQ(
      Js("[...document.querySelectorAll('#choosers select')].map((s) => s.selectedOptions[0].textContent)"),
      nlohmann::json({"turns", "margin [N]"}));
  EXPECT_THAT(browser.complaints(), IsEmpty());
  EXPECT_THAT(browser.requests(), Each(StartsWith("file:")));
}

TEST_F(VolumeReportTest, RefusesPartsWithOtherQuantities) {
  VolumeReport report = Example();
  report.maps[0].parts[3].values.pop_back();
  EXPECT_TRUE(Throws<ParameterError>([&] { report.Write(file); }, "'places'"));
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace tenon::volume_report_test
