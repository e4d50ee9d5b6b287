// Paths in files start from these files; the files of a run can be moved.

#include <tenon/apps/common/scenario_app.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::apps::scenario_file_test {

namespace fs = std::filesystem;
using ::testing::AllOf, ::testing::Contains, ::testing::HasSubstr, ::testing::Key, ::testing::Not;

struct Scenario {
  std::string app;
  YamlFile robot{"dogbot"};
  YamlFile profile{"standard"};
  std::vector<YamlFile> others;
  double speed = 0;
  static FieldList Fields() {
    return {{"app", &Scenario::app},
            {"robot", &Scenario::robot},
            {"profile", &Scenario::profile},
            {"others", &Scenario::others},
            {"speed_m_per_s", &Scenario::speed}};
  }
};

/// A user's directory: robots that do not ship, and scenarios that extend each other across directories.
struct ScenarioFileTest : ::testing::Test {
  ScenarioFileTest() {
    Write("base/base.yaml", "app: mine\nrobot: ../robots/mine.yaml\nspeed_m_per_s: 1\n");
    Write("deep/er/top.yaml", "extends: ../middle.yaml\nspeed_m_per_s: 3\n");
    Write("deep/middle.yaml", "extends: ../base/base.yaml\nspeed_m_per_s: 2\n");
    const fs::path shipped = DataDirectory() / "robots";
    std::string robot = ReadText(shipped / "dogbot.yaml");
    const std::size_t urdf = robot.find("dogbot.urdf");
    Write("robots/mine.yaml", robot.replace(urdf, 11, "bodies/dog.urdf"));
    Write("robots/bodies/dog.urdf", ReadText(shipped / "dogbot.urdf"));
  }
  ~ScenarioFileTest() override { fs::remove_all(home); }
  void Write(const fs::path& name, const std::string& text) const {
    fs::create_directories((home / name).parent_path());
    std::ofstream(home / name) << text;
  }
  std::string At(const char* name) const { return (home / name).string(); }

  const fs::path home =
      fs::canonical(fs::temp_directory_path()) / test::TemporaryPath("scenario_files").filename();
};

TEST_F(ScenarioFileTest, PathsStartFromTheFileThatNamesThem) {
  const auto scenario = LoadScenario(At("deep/er/top.yaml"), {}, "mine").Read<Scenario>();
  EXPECT_EQ(scenario.speed, 3);
  EXPECT_EQ(scenario.robot.text, At("robots/mine.yaml"));
  EXPECT_EQ(LoadQuadruped(scenario.robot).name, "dogbot");
  EXPECT_EQ(ResourceName(scenario.robot), At("robots/mine.yaml"));
}

TEST_F(ScenarioFileTest, PathsOfTheCommandLineStartFromTheWorkingDirectory) {
  const auto scenario =
      LoadScenario(At("base/base.yaml"), {"robot=other/robot.yaml", "profile=./mine"}, "mine")
          .Read<Scenario>();
  EXPECT_EQ(scenario.robot.text, (fs::current_path() / "other/robot.yaml").string());
  EXPECT_EQ(scenario.profile.text, (fs::current_path() / "mine").string());
}

TEST_F(ScenarioFileTest, MessagesNameFileLineAndKey) {
  Write("lost.yaml", "app: mine\nextends: nowhere/lost.yaml\n");
  Write("word.yaml", "app: mine\nextends: flt\n");
  Write("ring.yaml", "extends: deep/ring.yaml\n");
  Write("deep/ring.yaml", "extends: ../ring.yaml\n");
  Write("list.yaml", "app: mine\nothers: [{mass_kg: 1}]\n");  // no file that the map would change
  Write("newer.yaml", "format: 2\napp: mine\n");
  Write("extends.yaml", "format: 1\nextends: newer.yaml\n");
  for (const auto& [file, place, what] : std::vector<std::array<std::string, 3>>{
           {"lost.yaml", "lost.yaml:2:10: extends: ", "'" + At("nowhere/lost.yaml") + "'"},
           {"word.yaml", "word.yaml:2:10: extends: ", "'flt'"},
           {"ring.yaml", "deep/ring.yaml:1:10: extends: ", "'" + At("ring.yaml") + "'"},
           {"list.yaml", "list.yaml:2:10: others.0: ", ""},
           {"newer.yaml", "newer.yaml:1:9: format: 2", ""},
           {"extends.yaml", "newer.yaml:1:9: format: 2", ""}})
    EXPECT_TRUE(Throws<ParameterError>(
        [&, &file = file] { LoadScenario(home / file, {}, "mine").Read<Scenario>(); }, place, what));
  Write("robots/newer.yaml", "format: 2\n" + ReadText(home / "robots/mine.yaml"));
  EXPECT_TRUE(Throws<ParameterError>([&] { LoadQuadruped(YamlFile{At("robots/newer.yaml")}); }, "format: 2"));
}

TEST_F(ScenarioFileTest, ScenariosOfOtherAppsAreNotSuggested) {
  try {
    LoadScenario("flt", {}, "tenon-cdpr");
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_THAT(error.what(), HasSubstr("Choose one of D1, D1-arm, "));
    EXPECT_THAT(error.what(), Not(HasSubstr("flat")));
  }
  EXPECT_THAT(ListScenarios("tenon-cdpr"), Contains(Key("D1")));
  EXPECT_THAT(ListScenarios("tenon-cdpr"), Not(Contains(Key("flat"))));
  EXPECT_TRUE(Throws<ParameterError>([&] { LoadScenario("flt", {}, "mine"); }, "'flt'"));
}

TEST_F(ScenarioFileTest, AMapChangesKeysOfAFile) {
  const auto by_set =
      LoadScenario(At("base/base.yaml"), {"robot.foot_radius_m=0.03"}, "mine").Read<Scenario>();
  EXPECT_EQ(by_set.robot.text, "{\"file\": " + At("robots/mine.yaml") + ", \"foot_radius_m\": 0.03}");
  EXPECT_EQ(LoadQuadruped(by_set.robot).foot_radius, 0.03);
  EXPECT_EQ(ResourceName(by_set.robot), At("robots/mine.yaml") + ", changed");
  // In a file that extends another one the map changes its robot; without a robot it changes the default.
  Write("own.yaml", "extends: base/base.yaml\nrobot: {foot_radius_m: 0.04}\n");
  EXPECT_EQ(LoadQuadruped(LoadScenario(At("own.yaml"), {}, "mine").Read<Scenario>().robot).foot_radius, 0.04);
  Write("plain.yaml", "app: mine\n");
  const auto plain = LoadScenario(At("plain.yaml"), {"robot.foot_radius_m=0.05"}, "mine").Read<Scenario>();
  EXPECT_EQ(plain.robot.text, "{\"file\": dogbot, \"foot_radius_m\": 0.05}");
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        LoadQuadruped(LoadScenario(At("plain.yaml"), {"robot.foot_radius=1"}, "mine").Read<Scenario>().robot);
      },
      "'foot_radius_m'"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] { LoadScenario(At("plain.yaml"), {"robot=[1, 2]"}, "mine").Read<Scenario>(); },
      "--set robot=[1, 2]: robot: "));
}

TEST_F(ScenarioFileTest, RobotsOfOneKindAreSuggested) {
  const std::vector<std::string> walkers = ListResources("robots", "urdf"),
                                 cable_robots = ListResources("robots", "cables");
  EXPECT_THAT(walkers, AllOf(Contains("a1"), Contains("dogbot"), Not(Contains("cdpr_4"))));
  EXPECT_THAT(cable_robots, AllOf(Contains("cdpr_4"), Contains("cdpr_8"), Not(Contains("dogbot"))));
  EXPECT_EQ(walkers.size() + cable_robots.size(), ListResources("robots").size());
  try {
    LoadCdpr(YamlFile{"dogbot"});
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstrs("'dogbot'", "cdpr_4"), Not(HasSubstr("a1,"))));
  }
  EXPECT_TRUE(Throws<ParameterError>([&] { LoadQuadruped(YamlFile{"cdpr_5"}); }, "'cdpr_5'"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { LoadQuadruped(YamlFile{"my/dog.urdf"}); }, "tenon-robot my/dog.urdf"));
}

TEST_F(ScenarioFileTest, ARunsScenarioStartsFromAnywhere) {
  auto scenario = LoadScenario(At("deep/er/top.yaml"), {}, "mine").Read<Scenario>();
  scenario.others = {{"standard"}, {"{file: dogbot, urdf: " + At("robots/bodies/dog.urdf") + "}"}};
  const ScenarioFiles files(scenario);
  fs::create_directories(home / "run");
  files.Write(home / "run");
  fs::rename(home / "run", home / "moved");
  for (const char* gone : {"base", "deep", "robots"}) fs::remove_all(home / gone);

  const auto again = LoadScenario(At("moved/scenario.yaml"), {}, "mine").Read<Scenario>();
  EXPECT_EQ(again.speed, 3);
  EXPECT_EQ(LoadQuadruped(again.robot).name, "dogbot");
  EXPECT_EQ(again.profile.text, "standard");
  EXPECT_EQ(LoadQuadruped(again.others[1]).name, "dogbot");
  EXPECT_THAT(ReadText(home / "moved/scenario.yaml"),
              AllOf(HasSubstrs("format: 1\n", "files/robot.yaml", "files/robot.urdf", "files/others.1.urdf"),
                    Not(HasSubstr(home.string()))));
  EXPECT_EQ(std::distance(fs::directory_iterator(home / "moved/files"), {}),
            3 + 1);  // and the list of these files
}

TEST_F(ScenarioFileTest, AnEarlierRunsFilesGoAndNothingElse) {
  Write("run/files/mine.yaml", "robot: files/mine.yaml");
  const auto with_robot = LoadScenario(At("deep/er/top.yaml"), {}, "mine").Read<Scenario>();
  ScenarioFiles(with_robot).Write(home / "run");
  EXPECT_TRUE(fs::exists(home / "run/files/robot.yaml"));
  auto plain = with_robot;
  plain.robot = {"dogbot"};
  ScenarioFiles(plain).Write(home / "run");
  EXPECT_FALSE(fs::exists(home / "run/files/robot.yaml"));
  EXPECT_TRUE(fs::exists(home / "run/files/mine.yaml"));
  fs::remove(home / "run/files/mine.yaml");
  ScenarioFiles(with_robot).Write(home / "run");
  ScenarioFiles(plain).Write(home / "run");
  EXPECT_FALSE(fs::exists(home / "run/files"));
}

TEST_F(ScenarioFileTest, ASeedMayHaveASign) {
  Write("signed.yaml", "app: mine\nseed: +5\nspeed: {uniform: [0, 1]}\n");
  Write("plain.yaml", "app: mine\nseed: 5\nspeed: {uniform: [0, 1]}\n");
  auto with = LoadScenario(At("signed.yaml"), {}, "mine"),
       without = LoadScenario(At("plain.yaml"), {}, "mine");
  EXPECT_EQ(DrawScenario(with, {}), DrawScenario(without, {}));
}

TEST(BlameTest, ErrorsOfBlocksHaveThePlaceOfTheKeyOfTheirName) {
  const auto scenario = YamlDocument::Parse("mass: 3\nwalk:\n  pd: {kp: 1}\n", "cart.yaml");
  const auto blames = [&](const std::string& block, const std::string& place) {
    return Throws<ParameterError>(
        [&] { RunBlaming(scenario, [&] { Blame("", [&] { throw ParameterError("too weak", block); }); }); },
        place + ": too weak");
  };
  EXPECT_TRUE(blames("loop.pd", "cart.yaml:3:7: walk.pd"));
  EXPECT_TRUE(blames("loop.walk.joint_0", "cart.yaml:3:3: walk")) << "the diagram around it";
  EXPECT_TRUE(blames("loop.masses", "cart.yaml"));
  EXPECT_TRUE(blames("", "cart.yaml"));
}

enum class Mode { kOff, kOn };

struct Push {
  Eigen::Vector3d force_N{1, 2, 3};
  double duration_s = 0;
  static FieldList Fields() {
    return {{"force_N", &Push::force_N}, Required("duration_s", &Push::duration_s).Above(0).AtMost(9)};
  }
};

struct Listed : AppScenario {
  Mode mode = Mode::kOn;
  YamlFile robot{"dogbot"};
  std::optional<Push> push;
  std::vector<Push> pushes;
  std::map<std::string, Push> named;
  bool loud = false;
  int count = 3;
  static FieldList Fields() {
    return With({{"mode", &Listed::mode},
                 {"robot", &Listed::robot},
                 {"push", &Listed::push},
                 {"pushes", &Listed::pushes},
                 {"named", &Listed::named},
                 {"loud", &Listed::loud},
                 {"count", &Listed::count}});
  }
};

TEST(ScenarioKeysTest, EveryKeyWithTypeUnitRangeAndDefault) {
  std::map<std::string, std::string> keys;
  for (const ScenarioKey& key : KeysOf<Listed>())
    keys[key.key] =
        key.type + "; " + key.unit + "; " + (key.range.empty() ? "" : key.range + "; ") + key.initial;
  const std::map<std::string, std::string> expected{
      {"app", "text; ; required"},
      {"case", "text; ; required"},
      {"duration_s", "number; s; 10"},
      {"seed", "integer; ; 1"},
      {"log_rate_hz", "number; Hz; 100"},
      {"report.events", "list: text; ; []"},
      {"mode", "off, on; ; on"},
      {"robot", "file; ; dogbot"},
      {"push", "map; ; none"},
      {"push.force_N", "3 numbers; N; [1, 2, 3]"},
      {"push.duration_s", "number; s; above 0 and at most 9; required"},
      {"pushes", "list: map; ; []"},
      {"pushes[].force_N", "3 numbers; N; [1, 2, 3]"},
      {"named.NAME.duration_s", "number; s; above 0 and at most 9; required"},
      {"loud", "true or false; ; false"},
      {"count", "integer; ; 3"}};
  for (const auto& [key, what] : expected) EXPECT_EQ(keys[key], what) << key;
}

// The keys of the robot file that a scenario names.
TEST(ScenarioKeysTest, ListsTheKeysOfAFile) {
  std::map<std::string, std::string> keys;
  for (const ScenarioKey& key : KeysOfFile("robots", {"{file: dogbot, foot_radius_m: 0.03}"}, "robot"))
    keys[key.key] = key.type + "; " + key.unit + "; " + key.initial;
  EXPECT_EQ(keys["robot.foot_radius_m"], "in dogbot, changed; m; 0.03");
  EXPECT_EQ(keys["robot.feet.front_left"], "in dogbot, changed; ; front_left_foot");
  EXPECT_TRUE(KeysOfFile("hardware/legged", {"none"}, "hardware").empty());
}

// Read takes the keys of the table.
TEST(ScenarioKeysTest, KeysAreThoseThatAreRead) {
  auto document = YamlDocument::Parse("app: a\ncase: b\n", "scenario.yaml");
  document.Set("push.duration_s", "2");
  document.Set("log_rate_hz", "50");
  const auto scenario = document.Read<Listed>();
  EXPECT_EQ(scenario.push->duration_s, 2);
  EXPECT_EQ(scenario.log_rate_hz, 50);
}

TEST(ScenarioKeysTest, UnitsAreThoseOfTheNames) {
  const std::map<std::string, std::string> units{{"mass_kg", "kg"},
                                                 {"inertia_kg_m2", "kg m^2"},
                                                 {"rate_hz", "Hz"},
                                                 {"speed_m_per_s", "m/s"},
                                                 {"gains_per_s", "1/s"},
                                                 {"damping_N_m_s_per_rad", "N m s/rad"},
                                                 {"walk_rad_per_s_per_sqrt_s", "rad/s/√s"},
                                                 {"limit_rad_per_s2", "rad/s^2"},
                                                 {"friction", ""},
                                                 {"max_steps", ""}};
  for (const auto& [key, unit] : units) EXPECT_EQ(internal::UnitOfKey(key), unit) << key;
}

}  // namespace tenon::apps::scenario_file_test
