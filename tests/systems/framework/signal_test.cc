#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon {

// In gtest's matchers, an Element reads as its name and unit.
bool operator==(const Element& a, const Element& b) {
  return a.name == b.name && a.unit == b.unit && a.is_real == b.is_real;
}
void PrintTo(const Element& element, std::ostream* out) {
  *out << element.name << " [" << element.unit << (element.is_real ? "]" : "], whole");
}

namespace {

using internal::Archive, internal::Finiteness, internal::kBitwise, internal::TypeInfoOf,
    ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty;

enum class Phase { kStance = 1, kSwing = 2 };

struct Foot {
  double height = 0;
  Vec<3> p_W = Vec<3>::Zero();
  Phase phase = Phase::kStance;
  static FieldList Fields() {
    return {{"height", &Foot::height, "m"}, {"p_W", &Foot::p_W, "m"}, {"phase", &Foot::phase}};
  }
};

struct Robot {
  std::array<Foot, 2> feet;
  std::vector<double> battery;
  static FieldList Fields() { return {{"feet", &Robot::feet}, {"battery", &Robot::battery, "V"}}; }
};

struct Opaque {
  std::map<int, std::string> content;
};

template <class T>
std::vector<Element> Elements(const T& model, const Spec& spec = "signal") {
  return internal::ListElements(TypeInfoOf<T>(), &model, spec);
}

template <class T>
std::vector<double> Doubles(const T& value) {
  std::vector<double> doubles(internal::CountScalars(TypeInfoOf<T>(), &value));
  EXPECT_EQ(internal::ToDoubles(TypeInfoOf<T>(), &value, doubles.data()), doubles.data() + doubles.size());
  return doubles;
}

// ---- Elements ----

TEST(SignalTest, ScalarHasOneElementWithoutName) {
  EXPECT_THAT(Elements(1.5, {"force", "N"}), ElementsAre(Element{"", "N"}));
  EXPECT_THAT(Elements(true), ElementsAre(Element{"", "", false}));
  EXPECT_THAT(Elements(Phase::kSwing), ElementsAre(Element{"", "", false}));
}

TEST(SignalTest, VectorElementsAreNamedByTheSpecOrAxesOrIndices) {
  EXPECT_THAT(Elements(internal::Zeroed<Vec<2>>(), {"x", "m, m/s", "position, velocity"}),
              ElementsAre(Element{"position", "m"}, Element{"velocity", "m/s"}));
  EXPECT_THAT(Elements(internal::Zeroed<Vec<3>>(), {"p", "m"}),
              ElementsAre(Element{"x", "m"}, Element{"y", "m"}, Element{"z", "m"}));
  EXPECT_THAT(Elements(internal::Zeroed<Vec<2>>(), {"f", "N"}),
              ElementsAre(Element{"0", "N"}, Element{"1", "N"}));
  EXPECT_THAT(Elements(internal::Zeroed<Vec<2>>(), {"f", "N", "left"}),
              ElementsAre(Element{"left", "N"}, Element{"1", "N"}));
  EXPECT_THAT(Elements(Eigen::VectorXd(Eigen::VectorXd::Zero(2)), {"f", "N"}),
              ElementsAre(Element{"0", "N"}, Element{"1", "N"}));
}

TEST(SignalTest, MatrixElementsAreNamedByRowAndColumn) {
  EXPECT_THAT(
      Elements(internal::Zeroed<Eigen::Matrix2d>(), {"M", "kg"}),
      ElementsAre(Element{"0_0", "kg"}, Element{"1_0", "kg"}, Element{"0_1", "kg"}, Element{"1_1", "kg"}));
}

TEST(SignalTest, StructsDescribeThemselves) {
  EXPECT_THAT(Elements(Foot{}),
              ElementsAre(Element{"height", "m"}, Element{"p_W.x", "m"}, Element{"p_W.y", "m"},
                          Element{"p_W.z", "m"}, Element{"phase", "", false}));
  const std::vector<Element> elements = Elements(Robot{.feet = {}, .battery = {12, 48}});
  ASSERT_EQ(elements.size(), 12);
  EXPECT_EQ(elements[6], (Element{"feet.1.p_W.x", "m"}));
  EXPECT_EQ(elements[11], (Element{"battery.1", "V"}));
}

struct Biped {
  Vec<4> q_W{1, 0, 0, 0};
  std::array<Vec<3>, 2> feet{Vec<3>::Zero(), Vec<3>::Zero()};
  std::array<bool, 2> stands{};
  static FieldList Fields() {
    return {{"q_W", &Biped::q_W, "", "w,x,y,z"},
            {"feet", &Biped::feet, "m", "left,right"},
            {"stands", &Biped::stands, "", "left,right"}};
  }
};

TEST(SignalTest, MembersNameTheirElementsAndItems) {
  const std::vector<Element> elements = Elements(Biped());
  ASSERT_EQ(elements.size(), 12);
  EXPECT_EQ(elements[0], (Element{"q_W.w", ""}));
  EXPECT_EQ(elements[4], (Element{"feet.left.x", "m"}));
  EXPECT_EQ(elements[9], (Element{"feet.right.z", "m"}));
  EXPECT_EQ(elements[11], (Element{"stands.right", "", false}));
  EXPECT_THAT(Elements(std::array<double, 2>{}, {"load", "N", "left, right"}),
              ElementsAre(Element{"left", "N"}, Element{"right", "N"}));
}

TEST(SignalTest, WhatDoesNotDescribeItselfHasNoElements) {
  EXPECT_THAT(Elements(Opaque{}), IsEmpty());
  EXPECT_THAT(Elements(std::string("text")), IsEmpty());
}

// ---- Names of types ----

template <class T>
struct Pair {
  T first{}, second{};
};

TEST(SignalTest, TypesAreNamedAsOneWritesThem) {
  const auto name = []<class T>(const T&) { return internal::TypeName(TypeInfoOf<T>()); };
  EXPECT_EQ(name(1.5), "double");
  EXPECT_EQ(name(true), "bool");
  EXPECT_EQ(name(Phase::kSwing), "Phase");
  EXPECT_EQ(name(std::string()), "std::string");
  EXPECT_EQ(name(Foot()), "Foot");
  EXPECT_EQ(name(Vec<3>()), "Vec<3>");
  EXPECT_EQ(name(Vec<12>()), "Vec<12>");
  EXPECT_EQ(name(Eigen::VectorXd()), "Vec<X>");
  EXPECT_EQ(name(Eigen::Vector2f()), "Vec<2, float>");
  EXPECT_EQ(name(Eigen::Matrix<double, 6, Eigen::Dynamic>()), "Mat<6, X>");
  EXPECT_EQ(name(std::array<Vec<3>, 4>()), "std::array<Vec<3>, 4>");
  EXPECT_EQ(name(std::vector<Foot>()), "std::vector<Foot>");
  EXPECT_EQ(name(std::optional<Foot>()), "std::optional<Foot>");
  EXPECT_EQ(name(std::map<std::string, double>()), "std::map<std::string, double>");
  EXPECT_EQ(name(Pair<Vec<4>>()), "Pair<Vec<4>>");
  EXPECT_EQ(name(Opaque()), "Opaque");
}

// ---- Numbers ----

TEST(SignalTest, FlattensAndBack) {
  const Foot foot{.height = 0.5, .p_W = {1, 2, 3}, .phase = Phase::kSwing};
  EXPECT_THAT(Doubles(foot), ElementsAre(0.5, 1, 2, 3, 2));
  Foot copy;
  internal::FromDoubles(TypeInfoOf<Foot>(), &copy, Doubles(foot).data());
  EXPECT_EQ(copy.height, 0.5);
  EXPECT_EQ(copy.p_W, foot.p_W);
  EXPECT_EQ(copy.phase, Phase::kSwing);
  EXPECT_THAT(Doubles(Robot{.feet = {}, .battery = {12}}), ElementsAre(0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 12));
  EXPECT_THAT(Doubles(Eigen::Matrix2d{{1, 2}, {3, 4}}), ElementsAre(1, 3, 2, 4));  // as named: by columns
}

enum class Side { kLeft, kRight };

struct Step {
  double length = 0;
  std::array<Side, 2> sides{};
  bool stands = false;
  std::int8_t count = 0;
  static FieldList Fields() {
    return {{"length", &Step::length},
            {"sides", &Step::sides},
            {"stands", &Step::stands},
            {"count", &Step::count}};
  }
};

/// The message of the error when these numbers are stored in a T; without an error, checks that T returns
/// them.
template <class T>
std::string DoublesError(const std::vector<double>& numbers) {
  T value = internal::Zeroed<T>();
  try {
    internal::FromDoubles(TypeInfoOf<T>(), &value, numbers.data());
  } catch (const internal::NumberError& error) {
    return error.what();
  }
  EXPECT_EQ(Doubles(value), numbers);
  return "no error";
}

enum class Order { kFirst, kRungeKutta4, kXy };

TEST(SignalTest, EnumeratorsHaveTheirNamesInTheProgram) {
  EXPECT_EQ(EnumNames(Order()).size(), 3u);
  EXPECT_STREQ(EnumName(Order::kRungeKutta4), "runge_kutta_4");
  EXPECT_STREQ(EnumName(Order::kXy), "xy");
  EXPECT_STREQ(EnumName(static_cast<Order>(3)), "?");
  static_assert(!NamedEnum<Phase>, "its values do not begin at 0");
}

TEST(SignalTest, RefusesDoublesThatNoElementCanHold) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(DoublesError<Step>({0.5, 0, 1, 1, -128}), "no error");
  EXPECT_THAT(DoublesError<Step>({0.5, 0, 9, 1, 0}), HasSubstrs("'sides.1'", "0 (left), 1 (right)"));
  EXPECT_THAT(DoublesError<Step>({0.5, 0, 0.5, 1, 0}), HasSubstr("'sides.1'"));
  EXPECT_THAT(DoublesError<Step>({0.5, 0, 1, 2, 0}), HasSubstr("'stands'"));
  EXPECT_THAT(DoublesError<Step>({0.5, 0, 1, 1, 2.7}), HasSubstr("'count'"));
  EXPECT_THAT(DoublesError<Side>({-1}), HasSubstr("0 (left), 1 (right)"));
  EXPECT_EQ(DoublesError<int>({2147483647.0}), "no error");
  for (const double number : {2147483648.0, 1e300, kNan, -HUGE_VAL})
    EXPECT_THAT(DoublesError<int>({number}), HasSubstr("from -2147483648 to 2147483647")) << number;
  EXPECT_EQ(DoublesError<std::int64_t>({-9223372036854775808.0}), "no error");
  EXPECT_EQ(DoublesError<std::uint64_t>({18446744073709549568.0}), "no error");
  EXPECT_THAT(DoublesError<std::uint64_t>({18446744073709551616.0}), HasSubstr("18446744073709551615"));
  EXPECT_THAT(DoublesError<std::uint64_t>({-1}), HasSubstr("-1"));
  EXPECT_EQ(DoublesError<float>({HUGE_VAL}), "no error");
  EXPECT_THAT(DoublesError<float>({1e39}), HasSubstr("1e+39"));
  EXPECT_EQ(DoublesError<Vec<2>>({0.5, 1e300}), "no error");
}

TEST(SignalTest, AnEnumeratorWithoutNameStaysWhileOthersChange) {
  Step value;
  value.sides[1] = static_cast<Side>(9);
  const std::vector<double> numbers{-0.0, 0, 9, 1, 0};
  internal::FromDoubles(TypeInfoOf<Step>(), &value, numbers.data());
  EXPECT_EQ(Doubles(value), numbers);
  EXPECT_TRUE(std::signbit(value.length));
}

TEST(SignalTest, FinitenessFindsTheWorst) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto of = [](Vec<3> p) {
    const Foot foot{.height = 0, .p_W = p};
    return internal::FinitenessOf(TypeInfoOf<Foot>(), &foot);
  };
  EXPECT_EQ(of({1, 2, 3}), Finiteness::kFinite);
  EXPECT_EQ(of({1, -HUGE_VAL, 3}), Finiteness::kInfinite);
  EXPECT_EQ(of({HUGE_VAL, kNan, 3}), Finiteness::kNan);
  EXPECT_EQ(of({kNan, HUGE_VAL, 3}), Finiteness::kNan);
}

TEST(SignalTest, ZeroedStartsAtZeroWhateverTheTypeLeavesOpen) {
  EXPECT_EQ(internal::Zeroed<Vec<4>>(), Vec<4>::Zero());
  EXPECT_EQ(internal::Zeroed<double>(), 0);
  EXPECT_EQ(internal::Zeroed<Foot>().p_W, Vec<3>::Zero());
}

// ---- Storage ----

TEST(SignalTest, BytesAreCopiedWhereThatIsEnough) {
  static_assert(kBitwise<double> && kBitwise<Vec<3>> && kBitwise<Foot> && kBitwise<Phase>);
  static_assert(kBitwise<std::array<double, 4>>);
  static_assert(!kBitwise<Eigen::VectorXd> && !kBitwise<std::string> && !kBitwise<Robot> &&
                !kBitwise<Opaque>);
}

TEST(SignalTest, EvenVectorsAreNotOverAligned) {
  static_assert(alignof(Vec<2>) == alignof(double) && alignof(Vec<4>) == alignof(double));
  static_assert(alignof(Vec<3>) == alignof(double));
  static_assert(std::is_same_v<Vec<3>, Eigen::Vector3d>);
}

template <class T>
T StoreAndLoad(const T& value) {
  Archive archive;
  internal::Save(TypeInfoOf<T>(), &value, archive);
  T loaded{};
  internal::Load(TypeInfoOf<T>(), &loaded, archive);
  EXPECT_TRUE(archive.exhausted());
  return loaded;
}

TEST(SignalTest, ArchivesGiveBackWhatTheyTook) {
  EXPECT_EQ(StoreAndLoad(0.1), 0.1);
  EXPECT_EQ(StoreAndLoad(std::string("a word")), "a word");
  EXPECT_EQ(StoreAndLoad(Vec<3>(1, 2, 3)), Vec<3>(1, 2, 3));
  EXPECT_EQ(StoreAndLoad(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(5, 0, 1))),
            Eigen::VectorXd::LinSpaced(5, 0, 1));
  EXPECT_EQ(StoreAndLoad(Eigen::VectorXd()).size(), 0);
  EXPECT_EQ(StoreAndLoad(Eigen::MatrixXd(Eigen::MatrixXd::Identity(2, 3))), Eigen::MatrixXd::Identity(2, 3));
  EXPECT_EQ(StoreAndLoad(std::vector<std::string>{"", "b"}), (std::vector<std::string>{"", "b"}));
  const Robot robot =
      StoreAndLoad(Robot{.feet = {Foot{.height = 3}, Foot{.phase = Phase::kSwing}}, .battery = {1, 2}});
  EXPECT_EQ(robot.feet[0].height, 3);
  EXPECT_EQ(robot.feet[1].phase, Phase::kSwing);
  EXPECT_THAT(robot.battery, ElementsAre(1, 2));
}

TEST(SignalTest, ArchivesEnd) {
  Archive archive;
  archive.Write("abc", 3);
  double value = 0;
  EXPECT_TRUE(Throws<RunError>([&] { archive.Read(&value, sizeof(value)); }, "3 bytes"));
}

/// The message of the error when a T is loaded from these bytes.
template <class T>
std::string LoadError(const std::vector<std::uint64_t>& words) {
  Archive archive;
  archive.Write(words.data(), 8 * words.size());
  T value{};
  try {
    internal::Load(TypeInfoOf<T>(), &value, archive);
  } catch (const RunError& error) {
    return error.what();
  }
  return "no error";
}

TEST(SignalTest, ArchivesRefuseWhatNoValueCanBe) {
  using Small = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4, 1>;
  EXPECT_EQ(LoadError<Small>({2, 1, 7, 8}), "no error");
  EXPECT_THAT(LoadError<Small>({5, 1, 7, 8, 9, 10, 11}), HasSubstr("Vec<X>"));
  EXPECT_THAT(LoadError<Eigen::VectorXd>({1, 2, 7, 8}), HasSubstr("Vec<X>"));
  EXPECT_THAT(LoadError<std::optional<double>>({2, 1, 7, 8}), HasSubstr("std::optional<double>"));
  EXPECT_THAT(LoadError<Eigen::MatrixXd>({30, 30, 7, 8}), HasSubstr("32 bytes"));
  EXPECT_THAT(LoadError<bool>({2}), HasSubstr("damaged"));
  EXPECT_THAT(LoadError<Side>({99}), HasSubstr("damaged"));
}

// ---- Members that Fields() does not list ----

template <class T>
void Describe() {
  static_cast<void>(TypeInfoOf<T>());
}

struct Forgetful {
  double a = 0;
  bool b = false;
  bool c = false;  // where padding could be
  std::optional<Eigen::Vector3d> d{};
  static FieldList Fields() { return {{"a", &Forgetful::a}, {"b", &Forgetful::b}, {"d", &Forgetful::d}}; }
};
struct ForgetsTwo {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  std::vector<double> list{};
  Forgetful* pointer = nullptr;
  double last = 0;
  static FieldList Fields() { return {{"p", &ForgetsTwo::p}, {"last", &ForgetsTwo::last}}; }
};
struct ForgetsAnArray {
  double a = 0;
  double items[3] = {0, 0, 0};
  static FieldList Fields() { return {{"a", &ForgetsAnArray::a}}; }
};

TEST(SignalTest, AMemberThatIsNotListedIsRefused) {
  EXPECT_TRUE(Throws<BuildError>(Describe<Forgetful>, "Forgetful", "Undescribed"));
  EXPECT_TRUE(Throws<BuildError>(Describe<ForgetsTwo>, "ForgetsTwo", "'p'"));
  EXPECT_TRUE(Throws<BuildError>(Describe<ForgetsAnArray>, "ForgetsAnArray", "'a'"));
  // The type of an element is checked, too.
  EXPECT_TRUE(Throws<BuildError>(Describe<std::array<ForgetsTwo, 2>>, "ForgetsTwo"));
  struct Block final : LeafSystem<void> {
    InputPort<Forgetful> u{this, "u"};
  };
  DiagramBuilder builder;
  EXPECT_TRUE(Throws<BuildError>([&] { builder.Add<Block>("block"); }, "'block'", "Forgetful"));
}

/// A class that is no aggregate: its members cannot be counted.
class WithConstructor {
 public:
  WithConstructor() {}
  double a = 0;
  static FieldList Fields() { return {{"a", &WithConstructor::a}}; }

 private:
  [[maybe_unused]] int b_ = 0;
};
struct ForgetsInTheBase : Foot {
  double more = 0;
  static FieldList Fields() { return {{"more", &ForgetsInTheBase::more}}; }
};

TEST(SignalTest, MembersThatCannotBeCountedMustFillTheObject) {
  EXPECT_TRUE(Throws<BuildError>(Describe<WithConstructor>, "WithConstructor", "'a'"));
  EXPECT_TRUE(Throws<BuildError>(Describe<ForgetsInTheBase>, "ForgetsInTheBase"));
}

struct Listed {
  bool flag = false;
  double a = 0;  // behind padding
  std::optional<Eigen::Vector3d> maybe{};
  std::optional<Foot> foot{};
  std::function<void()> call{};
  Eigen::VectorXd list{};
  int items[3] = {0, 0, 0};
  std::shared_ptr<const double> shared{};
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  static FieldList Fields() {
    return {{"a", &Listed::a},           {"maybe", &Listed::maybe},  {"matrix", &Listed::matrix},
            {"foot", &Listed::foot},     {"list", &Listed::list},    {"flag", &Listed::flag},
            Undescribed(&Listed::items), Undescribed(&Listed::call), Undescribed(&Listed::shared)};
  }
};
struct Longer {
  Longer() = default;
  virtual ~Longer() = default;
  double a = 0;
  bool flag = false;
  static FieldList Fields() { return {{"a", &Longer::a}, {"flag", &Longer::flag}}; }
};
struct NoMembers {
  static FieldList Fields() { return {}; }
};

TEST(SignalTest, ListsOfAllMembersAreAccepted) {
  const internal::TypeInfo& type = TypeInfoOf<Listed>();
  ASSERT_EQ(type.fields.size(), 6U);
  for (const Field& field : type.fields) EXPECT_NE(std::string(field.name), "");
  EXPECT_NO_THROW(Describe<Longer>());
  EXPECT_NO_THROW(Describe<NoMembers>());
}

struct Cached {
  double a = 1;
  double cache = 0;
  static FieldList Fields() { return {{"a", &Cached::a}, Undescribed(&Cached::cache)}; }
};

struct WithConstants {
  double a = 1;
  std::shared_ptr<const double> constant = {};
  static FieldList Fields() { return {{"a", &WithConstants::a}, Undescribed(&WithConstants::constant)}; }
};
template <class T>
struct Remembers final : LeafSystem<void> {
  Scratch<T> memory{this, "memory"};
  OutputPort<double> y{this, "y", Uses(memory), [](T&) { return 0.0; }};
};

TEST(SignalTest, AMemoryThatIsNotDescribedAsAWholeCannotBeSaved) {
  DiagramBuilder builder;
  auto& cached = builder.Add<Remembers<Cached>>("block");
  const auto context = builder.Build()->CreateContext();
  context->Set(cached.memory, {2, 3});
  EXPECT_EQ(context->Clone()->Eval(cached.memory).cache, 3);
  EXPECT_EQ(context->EvalDoubles(cached.memory), std::vector<double>{2});
  EXPECT_TRUE(Throws<RunError>([&] { context->Save(); }, "'block.memory'", "Cached"));
  DiagramBuilder with_constants;
  with_constants.Add<Remembers<WithConstants>>("block");
  EXPECT_NO_THROW(with_constants.Build()->CreateContext()->Save());
}

TEST(SignalTest, AnyCopyableTypeTravelsThroughADiagram) {
  DiagramBuilder builder;
  auto& opaque = builder.AddFunction("opaque", Sampled{Hz(10)}, Uses(builder.time), [](double t) {
    return Opaque{{{static_cast<int>(10 * t + 0.5), "tick"}}};
  });
  auto& key =
      builder.AddFunction("key", Uses(opaque), [](const Opaque& o) { return o.content.begin()->first; });
  auto& robot = builder.AddFunction("robot", Uses(key), [](int n) {
    return Robot{.feet = {}, .battery = std::vector<double>(static_cast<std::size_t>(n), 12.0)};
  });
  Simulator simulator(builder.Build());
  simulator.RunTo(0.3);
  EXPECT_EQ(simulator.context().Eval(key), 3);
  EXPECT_EQ(simulator.context().Clone()->Eval(robot).battery.size(), 3);
}

/// The state of C code, and a handle.
struct ForeignStruct {
  int count = 0;
  char text[4] = {};
};
struct ForeignHandle {
  explicit ForeignHandle(int number = 0) : value(std::make_unique<int>(number)) {}
  ForeignHandle(const ForeignHandle& other) : ForeignHandle(*other.value) {}
  ForeignHandle& operator=(const ForeignHandle& other) { return *value = *other.value, *this; }
  std::unique_ptr<int> value;
};

}  // namespace

template <>
struct SnapshotOf<ForeignStruct> : BytesOf<ForeignStruct> {};
template <>
struct SnapshotOf<ForeignHandle> {
  static std::vector<std::byte> Save(const ForeignHandle& handle) {
    return std::vector<std::byte>(static_cast<std::size_t>(*handle.value));
  }
  static void Load(std::span<const std::byte> bytes, ForeignHandle& handle) {
    if (bytes.size() == 9) throw std::runtime_error("no handle has 9");
    *handle.value = static_cast<int>(bytes.size());
  }
};

namespace {

TEST(SignalTest, ForeignStatesAreSavedByTheirFunctionsOrTheirBytes) {
  DiagramBuilder builder;
  auto& plain = builder.Add<Remembers<ForeignStruct>>("plain");
  auto& handle = builder.Add<Remembers<ForeignHandle>>("handle");
  const auto context = builder.Build()->CreateContext();
  const auto set = [&](const ForeignStruct& value, int number) {
    context->Set(plain.memory, value);
    context->Set(handle.memory, ForeignHandle(number));
  };
  set({5, "abc"}, 1);
  const auto saved = context->Save();
  set({6, "x"}, 7);
  context->Restore(saved);
  EXPECT_EQ(context->Eval(plain.memory).count, 5);
  EXPECT_STREQ(context->Eval(plain.memory).text, "abc");
  EXPECT_EQ(*context->Eval(handle.memory).value, 1);
  set({6, "x"}, 9);
  const auto refused = context->Save();
  set({7, "y"}, 8);
  EXPECT_TRUE(Throws<RunError>([&] { context->Restore(refused); }, "'handle.memory'", "no handle has 9"));
  EXPECT_EQ(*context->Eval(handle.memory).value, 8);
}

}  // namespace
}  // namespace tenon
