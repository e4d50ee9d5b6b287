#include <tenon/apps/common/scenario_app.h>
#include <tenon/systems/text/text.h>

#include <gmock/gmock.h>

namespace tenon::apps::scenario_keys_test {

enum class Mode { kOff, kOn };

struct Push {
  Eigen::Vector3d force_N{1, 2, 3};
  double duration_s = 0;
  static FieldList Fields() {
    return {{"force_N", &Push::force_N}, Required("duration_s", &Push::duration_s).Above(0).AtMost(9)};
  }
};

struct Scenario : AppScenario {
  Mode mode = Mode::kOn;
  YamlFile robot{"dogbot"};
  std::optional<Push> push;
  std::vector<Push> pushes;
  std::map<std::string, Push> named;
  bool loud = false;
  int count = 3;
  static FieldList Fields() {
    return With({{"mode", &Scenario::mode},
                 {"robot", &Scenario::robot},
                 {"push", &Scenario::push},
                 {"pushes", &Scenario::pushes},
                 {"named", &Scenario::named},
                 {"loud", &Scenario::loud},
                 {"count", &Scenario::count}});
  }
};

TEST(ScenarioKeysTest, EveryKeyWithTypeUnitRangeAndDefault) {
  std::map<std::string, std::string> keys;
  for (const ScenarioKey& key : KeysOf<Scenario>())
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
  const auto scenario = document.Read<Scenario>();
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

}  // namespace tenon::apps::scenario_keys_test
