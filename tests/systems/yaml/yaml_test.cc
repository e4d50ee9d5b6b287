#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/diagonal_gains.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/temporary_path.h>

#include <sys/stat.h>

#include <set>

namespace tenon::yaml_test {

using ::testing::AllOf, ::testing::HasSubstr, ::testing::Not, ::testing::StartsWith;

enum class Gait { kStand, kTrot };

struct Leg {
  double mass = 1;
  Eigen::Vector3d hip = Eigen::Vector3d::Zero();
  static FieldList Fields() { return {Required("mass_kg", &Leg::mass), {"hip_m", &Leg::hip}}; }
  void Validate() const {
    if (mass <= 0) throw ParameterError("the mass must be positive");
  }
};

struct Robot {
  std::string name = "walker";
  Gait gait = Gait::kStand;
  double speed = 0.25;
  int steps = 3;
  std::uint64_t seed = 1;
  bool verbose = false;
  std::optional<double> limit;
  std::vector<Leg> legs;
  std::vector<double> knots;
  std::array<bool, 2> flags = {};
  std::array<int, 2> pair = {1, 2};
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();
  std::map<std::string, Leg> spare;
  std::optional<Leg> tail;
  static FieldList Fields() {
    return {{"name", &Robot::name},     {"gait", &Robot::gait}, {"speed_m_per_s", &Robot::speed},
            {"steps", &Robot::steps},   {"seed", &Robot::seed}, {"verbose", &Robot::verbose},
            {"limit_N", &Robot::limit}, {"legs", &Robot::legs}, {"knots", &Robot::knots},
            {"flags", &Robot::flags},   {"pair", &Robot::pair}, {"inertia_kg_m2", &Robot::inertia},
            {"spare", &Robot::spare},   {"tail", &Robot::tail}};
  }
};

Robot ReadRobot(const std::string& text) {
  return YamlDocument::Parse(text, "robot.yaml").Read<Robot>();
}

template <class Call>
std::string ErrorOf(Call&& call) {
  try {
    call();
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}
std::string ReadError(const std::string& text) {
  return ErrorOf([&] { ReadRobot(text); });
}
std::string SetError(const std::string& text, const std::string& key, const std::string& value) {
  return ErrorOf([&] {
    auto document = YamlDocument::Parse(text, "robot.yaml");
    document.Set(key, value);
    document.Read<Robot>();
  });
}

TEST(YamlReadTest, EveryKindOfMember) {
  const Robot robot = ReadRobot(R"(
name: "dog: one"
gait: trot
speed_m_per_s: +2.5e-1
steps: -4
seed: 18446744073709551615
verbose: true
limit_N: 7
legs:
  - {mass_kg: 2, hip_m: [1, 2, 3]}
  - mass_kg: .5
knots: [0, 0.5, 1.]
flags: [true, false]
pair: [5, 6]
inertia_kg_m2: [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
spare:
  front: {mass_kg: 3}
tail: {mass_kg: 4}
)");
  EXPECT_EQ(robot.name, "dog: one");
  EXPECT_EQ(robot.gait, Gait::kTrot);
  EXPECT_EQ(robot.speed, 0.25);
  EXPECT_EQ(robot.steps, -4);
  EXPECT_EQ(robot.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_TRUE(robot.verbose);
  EXPECT_EQ(robot.limit, 7.0);
  ASSERT_EQ(robot.legs.size(), 2u);
  EXPECT_EQ(robot.legs[0].hip, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(robot.legs[1].mass, 0.5);
  EXPECT_EQ(robot.knots, (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(robot.flags, (std::array<bool, 2>{true, false}));
  EXPECT_EQ(robot.pair, (std::array<int, 2>{5, 6}));
  EXPECT_EQ(robot.inertia(1, 2), 6);
  EXPECT_EQ(robot.spare.at("front").mass, 3);
  EXPECT_EQ(robot.tail->mass, 4);
}

TEST(YamlReadTest, MissingKeysKeepTheirDefaults) {
  for (const char* text : {"", "# nothing\n", "steps: 3\n"}) {
    const Robot robot = ReadRobot(text);
    EXPECT_EQ(robot.name, "walker");
    EXPECT_EQ(robot.pair[1], 2);
    EXPECT_FALSE(robot.limit);
  }
}

TEST(YamlReadTest, NullDiagonalsAliasesAndByteOrderMarks) {
  Robot robot;
  robot.limit = 3;
  robot.inertia.setConstant(7);
  YamlDocument::Parse("limit_N: null\ninertia_kg_m2: [1, 2, 3]", "robot.yaml").ReadInto(robot);
  EXPECT_FALSE(robot.limit);
  EXPECT_EQ(robot.inertia, Eigen::Matrix3d(Eigen::Vector3d(1, 2, 3).asDiagonal()));
  EXPECT_EQ(ReadRobot("legs: [&leg {mass_kg: 7}, *leg]").legs[1].mass, 7);
  EXPECT_EQ(ReadRobot("\xEF\xBB\xBFname: a\n").name, "a");
}

TEST(YamlReadTest, ReadIntoKeepsWhatTheFileLeavesOutAndIsAllOrNothing) {
  Robot robot;
  robot.steps = 9;
  YamlDocument::Parse("speed_m_per_s: 4", "robot.yaml").ReadInto(robot);
  EXPECT_EQ(robot.steps, 9);
  EXPECT_EQ(robot.speed, 4);
  EXPECT_THROW(YamlDocument::Parse("{speed_m_per_s: 5, steps: x}", "robot.yaml").ReadInto(robot),
               ParameterError);
  EXPECT_EQ(robot.speed, 4);
}

TEST(YamlReadTest, LoadNamesTheFile) {
  const std::string path = test::TemporaryPath("tenon_yaml_test.yaml");
  std::ofstream(path) << "name: a\nsteps: 7.5\n";
  EXPECT_THAT(ErrorOf([&] { YamlDocument::Load(path).Read<Robot>(); }), StartsWith(path + ":2:8: steps: "));
}

/// A text that is refused: the message begins with the place and the key, and names `part`.
struct Refusal {
  const char* text;
  const char* place;
  const char* part = "";
};

void ExpectRefused(const std::vector<Refusal>& cases) {
  for (const auto& [text, place, part] : cases)
    EXPECT_THAT(ReadError(text), AllOf(StartsWith(std::string("robot.yaml:") + place), HasSubstr(part)))
        << text;
}

TEST(YamlErrorTest, UnknownKeysNameTheNearestOne) {
  EXPECT_THAT(ReadError("name: a\nlegs:\n  - mass_kg: 1\n    hop_m: [1, 2, 3]\n"),
              AllOf(StartsWith("robot.yaml:4:5: legs.0.hop_m: unknown key"),
                    HasSubstrs("nearest valid key is 'hip_m'", "Valid keys: mass_kg, hip_m")));
  ExpectRefused({{"legs:\n  - mass_g: 1\n", "2:5: legs.0.mass_g: ", "from g to kg"},
                 {"speed_km_per_h: 1", "1:1: speed_km_per_h: ", "from km_per_h to m_per_s"},
                 {"inertia_g_mm2: 1", "1:1: inertia_g_mm2: ", "from g_mm2 to kg_m2"},
                 {"speed: 1", "1:1: speed: ", "'speed_m_per_s'"},
                 {"0: 1", "1:1: 0: ", "not a list"},
                 {"legs: {0: {mass_kg: 1}}", "1:7: legs: ", "its element 0 cannot be set alone"},
                 {"steps_s: 1", "1:1: steps_s: ", "'steps'"}});
  struct Empty {
    static FieldList Fields() { return {}; }
  };
  EXPECT_THAT(ErrorOf([] { YamlDocument::Parse("a: 1", "e.yaml").Read<Empty>(); }),
              StartsWith("e.yaml:1:1: a: "));
}

TEST(YamlErrorTest, MissingAndDoubleKeysAndKeysThatAreNoWords) {
  ExpectRefused({{"name: a\nlegs:\n  - hip_m: [1, 2, 3]\n", "3:5: legs.0: ", "mass_kg"},
                 {"name: a\nsteps: 3\nname: b\n", "3:1: ", "first at robot.yaml:1:1"},
                 {"legs: [{mass_kg: 1, mass_kg: 2}]", "1:", "'mass_kg'"},
                 {"[1, 2]: 3", "1:1: "},
                 {"~: 3", "1:1: "}});
  EXPECT_THAT(ErrorOf([] { YamlDocument::Parse("", "leg.yaml").Read<Leg>(); }),
              AllOf(StartsWith("leg.yaml:1:1: "), HasSubstr("mass_kg")));
}

TEST(YamlErrorTest, ValuesOfAnotherType) {
  ExpectRefused({{"speed_m_per_s: abc", "1:16: speed_m_per_s: expected a number, found 'abc'"},
                 {"speed_m_per_s: 1 m/s", "1:16: speed_m_per_s: ", "'1 m/s'"},
                 {"speed_m_per_s: 0x10", "1:16: speed_m_per_s: ", "'0x10'"},
                 {"speed_m_per_s: '3'", "1:16: speed_m_per_s: ", "quoted text '3'"},
                 {"speed_m_per_s:", "1:", "speed_m_per_s: "},
                 {"speed_m_per_s: [1]", "1:16: speed_m_per_s: ", "a list of 1"},
                 {"speed_m_per_s: {a: 1}", "1:16: speed_m_per_s: ", "a map"},
                 {"speed_m_per_s: 1e999", "1:16: speed_m_per_s: ", "range of a double"},
                 {"steps: 2.5", "1:8: steps: ", "from -2147483648 to 2147483647"},
                 {"steps: 3000000000", "1:8: steps: "},
                 {"seed: -1", "1:7: seed: ", "from 0 to 18446744073709551615"},
                 {"verbose: yes", "1:10: verbose: ", "'yes'"},
                 {"name: [a]", "1:7: name: ", "a list of 1"},
                 {"name:", "1:", "name: "},
                 {"gait: gallop", "1:7: gait: ", "stand, trot"},
                 {"legs:\n  - mass_kg: 1\n    hip_m: [1, 2]\n", "3:12: legs.0.hip_m: ", "a list of 3"},
                 {"pair: [1, 2, 3]", "1:7: pair: ", "a list of 2"},
                 {"inertia_kg_m2: [[1, 2, 3], [1, 2], [1, 2, 3]]", "1:28: inertia_kg_m2.1: ", "a list of 3"},
                 {"inertia_kg_m2: [1, 2, [3]]", "1:23: inertia_kg_m2.2: ", "a number"},
                 {"knots: 3", "1:8: knots: ", "a list"},
                 {"spare: 3", "1:8: spare: ", "a map"},
                 {"legs: [3]", "1:8: legs.0: ", "mass_kg, hip_m"},
                 {"hello", "1:1: ", "a map"},
                 {"tail:\n  mass_kg: -1\n", "2:3: tail: the mass must be positive"}});
  for (const char* text : {".nan", ".inf", "-.inf", "+.Inf", ".NaN", "nan", "inf", "-infinity"})
    ExpectRefused({{(std::string("speed_m_per_s: ") + text).c_str(), "1:16: speed_m_per_s: ", text}});
}

TEST(YamlErrorTest, WhatIsNoYaml) {
  ExpectRefused({{"name: a\nknots: [1, 2\nsteps: 3\n", "3:"},
                 {"name: a\n  steps: 3\n", "2:"},
                 {"legs: &a [*a]", "1:", "alias"},
                 {"name: a\n---\nname: b\n", "", "second document"},
                 {"<<: {name: a}\n", "", "merge key"},
                 {"speed_m_per_s: !!float 3", "1:16: ", "tag"}});
  EXPECT_THAT(ErrorOf([] { YamlDocument::Load("no/such.yaml"); }), HasSubstr("'no/such.yaml'"));
  EXPECT_THAT(ErrorOf([] { YamlDocument::Load(::testing::TempDir()); }), HasSubstr(::testing::TempDir()));
}

TEST(YamlSetTest, ReplacesAndAdds) {
  auto document = YamlDocument::Parse("legs: [{mass_kg: 1}, {mass_kg: 2}]", "robot.yaml");
  const auto before = document;
  document.Set("legs.1.mass_kg", "5");
  document.Set("legs.1.hip_m", "[1, 2, 3]");
  document.Set("tail.mass_kg", "6");
  document.Set("knots", "[1, 2]");
  document.Set("knots.0", "9");
  document.Set("gait", "trot");
  const Robot robot = document.Read<Robot>();
  EXPECT_EQ(robot.legs[0].mass, 1);
  EXPECT_EQ(robot.legs[1].mass, 5);
  EXPECT_EQ(robot.legs[1].hip.z(), 3);
  EXPECT_EQ(robot.tail->mass, 6);
  EXPECT_EQ(robot.knots, (std::vector<double>{9, 2}));
  EXPECT_EQ(robot.gait, Gait::kTrot);
  EXPECT_EQ(before.Read<Robot>().legs[1].mass, 2) << "a copy does not change";
}

TEST(YamlAddMissingTest, MapsMergeWhileListsAndScalarsStand) {
  const auto base = YamlDocument::Parse(
      "name: base\nspeed_m_per_s: 3\nknots: [1, 2, 3]\ntail: {mass_kg: 2, hip_m: [1, 2, 3]}\nextra: x",
      "base.yaml");
  auto document = YamlDocument::Parse("name: own\nknots: [7]\ntail: {mass_kg: 5}\nsteps: 4", "robot.yaml");
  document.AddMissing(base);
  EXPECT_THAT(ErrorOf([&] { document.Read<Robot>(); }),
              AllOf(StartsWith("base.yaml:5:1"), HasSubstr("extra")));
  document.Remove("extra");
  document.Remove("not there");
  const Robot robot = document.Read<Robot>();
  EXPECT_EQ(robot.name, "own");
  EXPECT_EQ(robot.speed, 3);
  EXPECT_EQ(robot.steps, 4);
  EXPECT_EQ(robot.knots, std::vector<double>{7});
  EXPECT_EQ(robot.tail->mass, 5);
  EXPECT_EQ(robot.tail->hip.z(), 3);
}

// A user can correct the file that inherits a value, but maybe not the file in which the value stands.
TEST(YamlAddMissingTest, AnInheritedValueIsPlacedInTheSectionThatInheritsIt) {
  auto document = YamlDocument::Parse("tail: {hip_m: [0, 0, 0]}", "robot.yaml");
  document.AddMissing(YamlDocument::Parse("steps: 2\ntail: {mass_kg: 3}\nlegs: [{mass_kg: 0}]", "base.yaml"));
  EXPECT_EQ(document.Placed("tail", "mass_kg: too heavy"),
            "robot.yaml:1:7: tail.mass_kg: too heavy (inherited from base.yaml:2:17)");
  EXPECT_EQ(document.Placed("tail", "hip_m: too wide"), "robot.yaml:1:15: tail.hip_m: too wide");
  EXPECT_EQ(document.Placed("legs.0", "mass_kg: too light"), "base.yaml:3:18: legs.0.mass_kg: too light")
      << "a section of the other file alone";
  document.Set("tail.mass_kg", "4");
  EXPECT_EQ(document.Placed("tail", "mass_kg: too heavy"), "--set tail.mass_kg=4: tail.mass_kg: too heavy");
}

TEST(YamlSetTest, ErrorsNameTheOverride) {
  EXPECT_THAT(SetError("steps: 1", "steps", "x"), StartsWith("--set steps=x: steps: "));
  EXPECT_THAT(SetError("steps: 1", "stops", "2"), StartsWith("--set stops=2: stops: "));
  EXPECT_THAT(SetError("steps: 1", "tail.hip_m", "[1, 2, 3]"),
              AllOf(StartsWith("--set tail.hip_m=[1, 2, 3]: tail: "), HasSubstr("mass_kg")));
  for (const char* text : {"name: a", "name:"})
    EXPECT_THAT(SetError(text, "name.first", "b"), StartsWith("--set name.first=b: name: "));
  EXPECT_THAT(SetError("steps: 1", "knots", "[1"), StartsWith("--set knots=[1: "));
  EXPECT_THAT(SetError("steps: 1", "tail", "{mass_kg: 1, mass_kg: 2}"), HasSubstr("mass_kg"));
  // Errors elsewhere in the file name the file; those of Validate() name both.
  EXPECT_THAT(SetError("name: a\nsteps: x", "seed", "3"), StartsWith("robot.yaml:2:8: steps: "));
  EXPECT_THAT(SetError("tail: {mass_kg: 1}", "tail.mass_kg", "-1"),
              AllOf(StartsWith("robot.yaml:1:7: tail: "), HasSubstr("--set tail.mass_kg=-1")));
  EXPECT_THAT(SetError("", "tail.mass_kg", "-1"), StartsWith("--set tail.mass_kg=-1: tail: "));
}

TEST(YamlPlaceTest, IsThatOfTheValueOrWhereItWouldBe) {
  auto document = YamlDocument::Parse("steps: 3\nlegs:\n  - mass_kg: 2\n  - mass_kg: 3\n", "robot.yaml");
  EXPECT_EQ(document.PlaceOf("steps"), "robot.yaml:1:8: steps");
  EXPECT_EQ(document.PlaceOf("legs.1.mass_kg"), "robot.yaml:4:14: legs.1.mass_kg");
  EXPECT_EQ(document.PlaceOf("legs.1.hip_m"), "robot.yaml:4:5: legs.1.hip_m");
  EXPECT_EQ(document.PlaceOf("gait"), "robot.yaml:1:1: gait");
  document.Set("steps", "4");
  EXPECT_EQ(document.PlaceOf("steps"), "--set steps=4: steps");
  auto empty = YamlDocument::Parse("", "robot.yaml");
  empty.Set("steps", "4");
  EXPECT_EQ(empty.PlaceOf("gait"), "robot.yaml:1:1: gait");
}

TEST(YamlPlaceTest, IsThatOfTheKeyThatAMessageBeginsWith) {
  const auto document = YamlDocument::Parse(
      "steps: 3\nlegs:\n  - mass_kg: 2\n  - mass_kg: 3\n    hip: {rate_hz: 1}\n", "robot.yaml");
  EXPECT_EQ(document.Placed("", "steps = 3 must be even"), "robot.yaml:1:8: steps: steps = 3 must be even");
  EXPECT_EQ(document.Placed("legs.1", "mass = 3 is much"),
            "robot.yaml:4:14: legs.1.mass_kg: mass = 3 is much");
  EXPECT_EQ(document.Placed("legs", "1.mass_kg is much"),
            "robot.yaml:4:14: legs.1.mass_kg: 1.mass_kg is much");
  EXPECT_EQ(document.Placed("legs", "1: hip: rate: too low"), "robot.yaml:5:20: legs.1.hip.rate_hz: too low");
  EXPECT_EQ(document.Placed("legs.1", "hip.length is short"),
            "robot.yaml:5:10: legs.1.hip: hip.length is short");
  // Neither a part of a key counts nor a key later in the message.
  EXPECT_EQ(document.Placed("legs.1", "the mass is much"), "robot.yaml:4:5: legs.1: the mass is much");
  EXPECT_EQ(document.Placed("legs.1", "masses are much"), "robot.yaml:4:5: legs.1: masses are much");
  EXPECT_EQ(document.Placed("", "no robot"), "robot.yaml: no robot");
}

TEST(YamlSetTest, PathsThatLeadNowhere) {
  EXPECT_THAT(SetError("knots: [1, 2]", "knots.2", "3"),
              AllOf(StartsWith("--set knots.2=3: "), HasSubstrs("'knots'", "'2'")));
  EXPECT_THAT(SetError("knots: [1, 2]", "knots.a", "3"), HasSubstr("'a'"));
  EXPECT_THAT(SetError("steps: 1", "steps.a", "3"), HasSubstr("'steps'"));
  for (const char* key : {"", ".", "a.", ".a", "a..b"})
    EXPECT_THAT(SetError("", key, "3"), HasSubstr("--set"));
}

TEST(YamlWriteTest, BlockStyleWithListsInOneLine) {
  Robot robot;
  robot.legs = {Leg{2, {1, 0.5, -0.1}}};
  robot.knots = {1, 2};
  EXPECT_EQ(WriteYaml(robot), R"(name: walker
gait: stand
speed_m_per_s: 0.25
steps: 3
seed: 1
verbose: false
limit_N: null
legs:
  - mass_kg: 2
    hip_m: [1, 0.5, -0.1]
knots: [1, 2]
flags: [false, false]
pair: [1, 2]
inertia_kg_m2: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
spare: {}
tail: null
)");
}

TEST(YamlWriteTest, RoundTripIsExact) {
  const double nasty[] = {0.1,
                          -0.0,
                          1.0 / 3.0,
                          1e22,
                          1e-300,
                          std::numeric_limits<double>::denorm_min(),
                          std::numeric_limits<double>::max(),
                          std::nextafter(1.0, 2.0)};
  Robot robot;
  robot.gait = Gait::kTrot;
  robot.steps = std::numeric_limits<int>::min();
  robot.seed = std::numeric_limits<std::uint64_t>::max();
  robot.verbose = true;
  robot.limit = 0.1 + 0.2;
  robot.legs = {Leg{M_PI, {M_E, -0.0, 1e-7}}, Leg{}};
  robot.knots.assign(std::begin(nasty), std::end(nasty));
  robot.flags = {true, false};
  robot.inertia << 0.1, -0.0, 3, 4, 5, 6, 7, 8, 1.0 / 7.0;
  robot.spare = {{"a b", Leg{3}}, {"12", Leg{4}}, {"null", Leg{5}}, {"x: y #", Leg{6}}};
  robot.tail = Leg{8};
  const std::string text = WriteYaml(robot);
  const Robot read = ReadRobot(text);
  EXPECT_EQ(WriteYaml(read), text);
  ASSERT_EQ(read.knots.size(), robot.knots.size());
  EXPECT_EQ(std::memcmp(read.knots.data(), robot.knots.data(), sizeof nasty), 0);
  EXPECT_EQ(std::memcmp(read.inertia.data(), robot.inertia.data(), sizeof(double) * 9), 0);
  EXPECT_EQ(read.limit, robot.limit);
  EXPECT_EQ(read.seed, robot.seed);
  EXPECT_EQ(read.steps, robot.steps);
  EXPECT_EQ(read.legs[0].mass, M_PI);
  EXPECT_EQ(read.flags, robot.flags);
  EXPECT_EQ(read.spare.at("null").mass, 5);
  EXPECT_EQ(read.tail->mass, 8);
}

TEST(YamlWriteTest, RoundTripOfText) {
  Robot robot;
  for (const char* name :
       {"",     " ", "a",  "true", "null", "~",  "3",         "-1.5",     ".inf", "- a", "a: b", "a:", "#x",
        "x #y", "'", "\"", "\\",   "a\nb", "\n", "a\tb",      "\x01",     "[a]",  "{",   "&a",   "*a", "!t",
        "%",    "@", "`",  "|",    ">",    "?",  "trailing ", " leading", "---",  "...", "µ°é",  "a,b"}) {
    robot.name = name;
    EXPECT_EQ(ReadRobot(WriteYaml(robot)).name, name);
  }
}

TEST(YamlReadTest, RefusesWhatIsNotUtf8) {
  for (const char* bad : {"\xe9", "\xff", "\xc3(", "\xed\xa0\x80", "\xf0\x82\x82\xac"})
    EXPECT_THAT(ErrorOf([&] { YamlDocument::Parse(std::string("a: 1\nname: ") + bad, "robot.yaml"); }),
                HasSubstr("robot.yaml:2:7: byte 0x"))
        << bad;
  // Text in UTF-16 contains the byte 0.
  const std::string wide("a\0: \0\x31\0", 7);
  EXPECT_THAT(ErrorOf([&] { YamlDocument::Parse(wide, "robot.yaml"); }),
              HasSubstr("robot.yaml:1:2: byte 0x00"));
}

// ---- Size: without limits, these texts would take hours or all memory ----

std::string Repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

// Reading takes linear time: well below a second here, where quadratic time would be hours.
TEST(YamlSizeTest, AHundredThousandKeysAreRead) {
  std::string text = "spare:\n";
  for (int i = 0; i < 99'999; ++i) text += "  leg_" + std::to_string(i) + ": {mass_kg: 1}\n";
  EXPECT_EQ(ReadRobot(text).spare.size(), 99'999u);
}

TEST(YamlSizeTest, LongListsAreRefusedByTheirKey) {
  EXPECT_THAT(ReadError("steps: 1\nlegs:\n  - hip_m: [" + Repeated("1, ", 1'000'000) + "]"),
              AllOf(StartsWith("robot.yaml:3:"), HasSubstrs("legs.hip_m: ", "500000")));
}

TEST(YamlSizeTest, AliasesCountAsWhatTheyRepeat) {
  std::string text = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";  // ten times more in each line
  for (int i = 1; i < 12; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    text +=
        "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + Repeated(last + ", ", 9) + last + "]\n";
  }
  EXPECT_THAT(ReadError(text), AllOf(StartsWith("robot.yaml:6:"), HasSubstrs("a5: ", "500000")));
}

TEST(YamlSizeTest, LargeFilesPipesAndDevicesAreRefused) {
  const std::string file = test::TemporaryPath("large.yaml"), pipe = test::TemporaryPath("pipe.yaml");
  std::ofstream{file};
  std::filesystem::resize_file(file, 17'000'000);
  EXPECT_THAT(ErrorOf([&] { YamlDocument::Load(file); }), HasSubstr("more than 16777216 bytes"));
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& other : {std::string("/dev/zero"), pipe})
    EXPECT_THAT(ErrorOf([&] { YamlDocument::Load(other); }), HasSubstr("cannot read '" + other + "': not a"));
  std::filesystem::remove(file);
  std::filesystem::remove(pipe);
}

TEST(YamlSizeTest, DeepNestingIsRefused) {
  EXPECT_THAT(ReadError("legs: " + Repeated("[", 100'000)), StartsWith("robot.yaml:1:"));
}

TEST(YamlErrorTest, LongTextsAndControlCharactersAreCutAndEscaped) {
  const std::string error = ReadError("steps: \"\\x1b[2J" + Repeated("é", 1000) + "\"");
  EXPECT_THAT(error, AllOf(HasSubstrs("'\\x1b[2Jé", "é…'"), Not(HasSubstr("\x1b"))));
  EXPECT_LT(error.size(), 300u);
  EXPECT_LT(ReadError(Repeated("k", 500) + ": 1").size(), 500u);
  EXPECT_LT(SetError("", Repeated("k", 5000), Repeated("v", 5000)).size(), 600u);
  EXPECT_THAT(ReadError("steps: \"\\u009b2J\""), HasSubstr("'\\x9b2J'"));  // a control character, too
}

TEST(YamlWriteTest, RefusesWhatCannotBeReadAgain) {
  Robot robot;
  robot.speed = std::numeric_limits<double>::infinity();
  EXPECT_THAT(ErrorOf([&] { WriteYaml(robot); }), HasSubstr("speed_m_per_s: inf"));
  robot = Robot{};
  robot.gait = static_cast<Gait>(7);
  EXPECT_THAT(ErrorOf([&] { WriteYaml(robot); }), HasSubstr("gait: "));
}

struct Anything {
  std::map<std::string, YamlText> values;
  static FieldList Fields() { return {{"values", &Anything::values}}; }
};

TEST(YamlTextTest, KeepsAnyValueOnOneLine) {
  const auto document = YamlDocument::Parse(
      "values:\n  number: 1e-3\n  text: 'no # comment, \"quoted\"'\n  list:\n    - [1, 2]\n    - {a.b: "
      "yes}\n  none:\n",
      "a");
  const auto any = document.Read<Anything>().values;
  EXPECT_EQ(any.at("number").text, "1e-3");
  EXPECT_EQ(any.at("list").text, "[[1, 2], {\"a.b\": yes}]");
  EXPECT_EQ(any.at("none").text, "null");
  // The text can be read again, quoted or not, with the same result.
  for (const auto& [key, value] : any) {
    const auto again = YamlDocument::Parse("values: {x: " + value.text + "}", "again").Read<Anything>();
    EXPECT_EQ(again.values.at("x").text, value.text) << key;
  }
  EXPECT_EQ(YamlDocument::Parse(document.Flow(), "flow").Flow(), document.Flow());
  const auto written = YamlDocument::Parse(WriteYaml(document.Read<Anything>()), "written").Read<Anything>();
  for (const auto& [key, value] : any) EXPECT_EQ(written.values.at(key).text, value.text) << key;
}

struct Choice {
  YamlFile robot{"dogbot"};
  YamlText any;
  static FieldList Fields() { return {{"robot", &Choice::robot}, {"any", &Choice::any}}; }
};

TEST(YamlFileTest, PathsStartFromTheFileInWhichTheyStand) {
  auto document = YamlDocument::Parse("any: [own.csv, plain]\n", "/home/own.yaml");
  document.AddMissing(YamlDocument::Parse("robot: ../robots/x.yaml\nany: b\n", "/base/sub/base.yaml"));
  EXPECT_EQ(document.Read<Choice>().robot.text, "/base/robots/x.yaml");
  EXPECT_EQ(document.Read<Choice>().any.text, "[/home/own.csv, plain]");
  EXPECT_EQ(document.Path("robot"), "/base/robots/x.yaml");
  EXPECT_THAT(document.Paths(), ::testing::ElementsAre(std::pair("any.0", "/home/own.csv"),
                                                       std::pair("robot", "/base/robots/x.yaml")));
  EXPECT_EQ(document.WithAbsolutePaths().Flow(),
            "{\"any\": [/home/own.csv, plain], \"robot\": /base/robots/x.yaml}");
  document.Set("robot", "x.yaml");
  EXPECT_EQ(document.Path("robot"), (std::filesystem::current_path() / "x.yaml").string());
}

TEST(YamlFileTest, ANameTakesWhatDiffers) {
  const auto read = [](const std::string& text, const std::string& base) {
    auto document = YamlDocument::Parse(text, "/own.yaml");
    document.AddMissing(YamlDocument::Parse(base, "/base.yaml"));
    document.Set("robot.legs", "4");
    return document.Read<Choice>().robot.text;
  };
  EXPECT_EQ(read("", ""), "{\"file\": dogbot, \"legs\": 4}");
  EXPECT_EQ(read("", "robot: a1"), "{\"file\": a1, \"legs\": 4}");
  EXPECT_EQ(read("robot: {mass_kg: 3}", "robot: a1"), "{\"file\": a1, \"mass_kg\": 3, \"legs\": 4}");
  EXPECT_EQ(read("robot: {file: b.yaml}", "robot: {file: a1, mass_kg: 3}"),
            "{\"file\": /b.yaml, \"mass_kg\": 3, \"legs\": 4}");
  auto by_map = YamlDocument::Parse("robot: a1", "own.yaml");
  by_map.Set("robot", "{legs: 4}");
  EXPECT_EQ(by_map.Read<Choice>().robot.text, "{\"file\": a1, \"legs\": 4}");
  // A number is no name: a map replaces it and does not refer to it as a file.
  auto document = YamlDocument::Parse("tail: {mass_kg: {uniform: [1, 2]}}", "own.yaml");
  document.AddMissing(YamlDocument::Parse("tail: {mass_kg: 2}", "base.yaml"));
  EXPECT_EQ(document.Flow(), "{\"tail\": {\"mass_kg\": {\"uniform\": [1, 2]}}}");
  const Choice written =
      YamlDocument::Parse(WriteYaml(Choice{{"{file: a1, legs: 4}"}, {"3"}}), "w").Read<Choice>();
  EXPECT_EQ(written.robot.text, "{\"file\": a1, \"legs\": 4}");
}

TEST(YamlFormatTest, NewerOnesAreRefused) {
  EXPECT_EQ(ReadRobot("format: 1\nname: a").name, "a");
  ExpectRefused({{"format: 2\nname: a", "1:9: format: "},
                 {"format: 0", "1:9: format: "},
                 {"format: x", "1:9: format: "},
                 {"tail: {mass_kg: 1, format: 1}", "1:20: tail.format: "}});
}

struct Aged {
  double speed = 0;
  std::optional<Leg> leg;
  static FieldList Fields() { return {{"speed_m_per_s", &Aged::speed}, {"leg", &Aged::leg}}; }
  static std::vector<RenamedKey> Renamed() {
    return {{"velocity_m_per_s", "speed_m_per_s"}, {"leg.weight_kg", "leg.mass_kg"}};
  }
};

TEST(YamlFormatTest, RenamedKeysNameTheirSuccessors) {
  const auto error = [](const std::string& text) {
    return ErrorOf([&] { YamlDocument::Parse(text, "old.yaml").Read<Aged>(); });
  };
  EXPECT_THAT(error("speed_m_per_s: 3\nvelocity_m_per_s: 2\n"),
              AllOf(StartsWith("old.yaml:2:1: velocity_m_per_s"), HasSubstr("to speed_m_per_s")));
  EXPECT_THAT(error("leg:\n  weight_kg: 2\n"),
              AllOf(StartsWith("old.yaml:2:3: leg.weight_kg"), HasSubstr("to leg.mass_kg")));
  EXPECT_EQ(error("speed_m_per_s: 3\nleg: {mass_kg: 2}\n"), "no error");
}

TEST(YamlKeysTest, AreInTheOrderOfTheFileAndMayHaveDots) {
  const auto document = YamlDocument::Parse("vary:\n  b.0.c: {z: 1, a: 2}\n  a: 3\n", "file");
  EXPECT_THAT(document.Keys("vary"), ::testing::ElementsAre("b.0.c", "a"));
  EXPECT_THAT(document.Keys("vary.b.0.c"), ::testing::ElementsAre("z", "a"));
  EXPECT_TRUE(document.Keys("vary.a").empty());
  EXPECT_TRUE(document.Keys("vary.none").empty());
  EXPECT_EQ(document.PlaceOf("vary.b.0.c.a"), "file:2:20: vary.b.0.c.a");
}

struct Load {
  double mass = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  static FieldList Fields() { return {{"mass_kg", &Load::mass}, {"place_m", &Load::place}}; }
};

TEST(YamlDrawTest, PutsNumbersInThePlaceOfDistributions) {
  const auto draw = [&](std::uint64_t seed) {
    auto document = YamlDocument::Parse(
        "mass_kg: {uniform: [2, 3]}\nplace_m: [{normal: [1, 0.1]}, 0, {lognormal: [0, 0.1]}]\n", "load.yaml");
    const auto drawn = document.Draw(seed);
    const auto load = document.Read<Load>();
    EXPECT_EQ(drawn.size(), 3U);
    EXPECT_EQ(drawn[0], std::pair(std::string("mass_kg"), load.mass));
    EXPECT_EQ(drawn[1], std::pair(std::string("place_m.0"), load.place[0]));
    EXPECT_EQ(drawn[2], std::pair(std::string("place_m.2"), load.place[2]));
    EXPECT_TRUE(load.mass >= 2 && load.mass < 3);
    EXPECT_NEAR(load.place[0], 1, 0.6);  // six standard deviations
    EXPECT_NEAR(std::log(load.place[2]), 0, 0.6);
    return load.mass;
  };
  std::set<double> masses;
  for (std::uint64_t seed = 0; seed < 50; ++seed) masses.insert(draw(seed));
  EXPECT_EQ(masses.size(), 50U);
  EXPECT_EQ(draw(5), draw(5));
}

TEST(YamlDrawTest, RefusesDistributionsThatMakeNoSense) {
  const auto error = [](const std::string& text) {
    return ErrorOf([&] { YamlDocument::Parse(text, "load.yaml").Draw(1); });
  };
  EXPECT_THAT(error("mass_kg: {uniform: [3, 2]}"),
              AllOf(StartsWith("load.yaml:1:20: "), HasSubstr("uniform")));
  EXPECT_THAT(error("mass_kg: {normal: [3, -2]}"),
              AllOf(StartsWith("load.yaml:1:19: "), HasSubstr("normal")));
  EXPECT_THAT(error("mass_kg: {normal: 3}"), StartsWith("load.yaml:1:19: "));
}

struct Noise {
  double absolute = 0;
  double bias = 0;
  static FieldList Fields() { return {{"absolute", &Noise::absolute}, {"bias", &Noise::bias}}; }
};

struct Gains {
  DiagonalGains stiffness = 100;
  double offset = 0;
  static FieldList Fields() {
    return {
        Field("stiffness_N_per_m", &Gains::stiffness)
            .Positive()
            .Scaled("stiffness_mg_per_l", [](double k, const Scale& s) { return k * s.Weight() / s.length; }),
        Field("offset_m", &Gains::offset).Scaled("offset_l", [](double ratio, const Scale& s) {
          return ratio * s.length;
        })};
  }
};

struct Sensor {
  Noise noise;
  Vec<3> deviation = Vec<3>::Zero();
  Rate rate = Hz(1000);
  Gains gains;
  std::optional<int> bits;
  static FieldList Fields() {
    return {Field("noise_N", &Sensor::noise, &Noise::absolute).AtLeast(0),
            Field("bias_N", &Sensor::noise, &Noise::bias),
            Field("deviation_m", &Sensor::deviation).AtLeast(0).Uniform(),
            {"rate_hz", &Sensor::rate},
            {"gains", &Sensor::gains},
            {"bits", &Sensor::bits}};
  }
};

Sensor ReadSensor(const std::string& text, const Scale* scale = nullptr) {
  return YamlDocument::Parse(text, "sensor.yaml").Read<Sensor>(scale);
}

TEST(YamlFieldTest, MembersOfMembersOneNumberForAVectorAndRates) {
  const Sensor sensor = ReadSensor("{noise_N: 2, bias_N: -1, deviation_m: 0.5, rate_hz: 300}");
  EXPECT_EQ(sensor.noise.absolute, 2);
  EXPECT_EQ(sensor.noise.bias, -1);
  EXPECT_EQ(sensor.deviation, Vec<3>(0.5, 0.5, 0.5));
  EXPECT_EQ(sensor.rate.hz(), 300);
  const Sensor again = ReadSensor(WriteYaml(sensor));
  EXPECT_EQ(again.deviation, sensor.deviation);
  EXPECT_EQ(again.rate, sensor.rate);
  for (const auto& [text, key] : std::vector<std::pair<std::string, std::string>>{
           {"noise_N: -1", "noise_N"}, {"deviation_m: -1", "deviation_m"}, {"rate_hz: 0", "rate_hz"}})
    EXPECT_THAT(ErrorOf([&, text = text] { ReadSensor(text); }),
                AllOf(StartsWith("sensor.yaml:1:"), HasSubstr(key)));
}

// A robot of 2 kg and 0.5 m with g = 10 m/s^2: m g / l = 40 N/m.
TEST(YamlScaleTest, FilesForAllSizesGiveNumbersInUnitsOfTheScale) {
  const Scale scale{.mass = 2, .length = 0.5, .gravity = 10};
  const Sensor sensor = ReadSensor("gains: {stiffness_mg_per_l: 3, offset_l: 0.1}", &scale);
  EXPECT_EQ(sensor.gains.stiffness, 120);
  const Sensor several = ReadSensor("gains: {stiffness_mg_per_l: [3, 5], offset_l: 0.1}", &scale);
  EXPECT_EQ(several.gains.stiffness, (DiagonalGains{120, 200}));
  for (const Sensor& given : {sensor, several})
    EXPECT_EQ(ReadSensor(WriteYaml(given)).gains.stiffness, given.gains.stiffness);
  EXPECT_EQ(sensor.gains.offset, 0.05);
  const auto error = [&](const std::string& text, const Scale* of) {
    return ErrorOf([&] { ReadSensor(text, of); });
  };
  EXPECT_THAT(error("gains: {stiffness_mg_per_l: 3}", nullptr), HasSubstr("stiffness_N_per_m"));
  EXPECT_THAT(error("gains: {stiffness_N_per_m: 3}", &scale), HasSubstr("stiffness_mg_per_l"));
  EXPECT_THAT(error("gains: {stiffness_mg_per_l: -3}", &scale), HasSubstr("above 0"));
  EXPECT_THAT(error("gains: {}", &scale), HasSubstr("missing: stiffness_mg_per_l")) << "holds for one size";
  EXPECT_THAT(error("rate_hz: 5", &scale), HasSubstr("missing: gains"));
}

struct Bench {
  YamlChanges<Sensor> sensor;
  static FieldList Fields() { return {{"sensor", &Bench::sensor}}; }
};

TEST(YamlChangesTest, ReplaceKeysOfAFile) {
  const auto read = [](const std::string& text) {
    return YamlDocument::Parse(text, "setup.yaml").Read<Bench>();
  };
  const Bench setup = read("sensor: {noise_N: 3, bits: null, gains: {offset_m: 0.2}}");
  auto document =
      YamlDocument::Parse("sensor: {noise_N: 1, bits: 14, gains: {stiffness_N_per_m: 7}}", "hardware");
  document.Change("sensor", setup.sensor);
  const Sensor both = document.ReadAt<Sensor>("sensor");
  EXPECT_EQ(both.noise.absolute, 3);
  EXPECT_EQ(both.bits, 14) << "null is not set";
  EXPECT_EQ(both.gains.stiffness, 7);
  EXPECT_EQ(both.gains.offset, 0.2);
  EXPECT_EQ(read(WriteYaml(setup)).sensor.text, setup.sensor.text);
  EXPECT_THAT(ErrorOf([&] { read("sensor: {noise_N: -3}"); }),
              AllOf(StartsWith("setup.yaml:1:"), HasSubstr("sensor.noise_N")));
}

}  // namespace tenon::yaml_test
