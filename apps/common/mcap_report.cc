#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/tenon_report.h>
#include <tenon/systems/ros2/mcap.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

namespace tenon::apps {
namespace {

using internal::TypeInfo;

const Rate kRate = Hz(100);
constexpr std::size_t kMostNumbers = 200'000'000;  // that a report holds

/// The numbers of a topic's messages, at most one message per sample of the report.
struct Numbers {
  const TypeInfo* type = nullptr;
  std::vector<std::size_t> columns;  ///< indices of the numbers that are shown
  std::size_t scalars = 0;           ///< of a whole message
  std::string elements;
  std::vector<long> samples;   ///< number of the sample of each row
  std::vector<double> values;  ///< row by row
};

struct TopicParams {
  std::shared_ptr<const Numbers> numbers;
};

/// Outputs the last message of a topic, before it the first one.
class Topic final : public LeafSystem<TopicParams> {
 public:
  using LeafSystem::LeafSystem;
  OutputPort<Eigen::VectorXd> message{this,
                                      {"message", "", params.numbers->elements},
                                      Row(0),
                                      Sampled{kRate},
                                      Uses(time),
                                      [this](double t, Eigen::VectorXd* out) {
                                        const auto& samples = params.numbers->samples;
                                        const auto next = std::ranges::upper_bound(samples, SampleAt(t));
                                        *out = Row(std::max<std::ptrdiff_t>(next - samples.begin(), 1) - 1);
                                      }};
  static long SampleAt(double t) { return std::lround(t * kRate.hz()); }

 private:
  Eigen::Map<const Eigen::VectorXd> Row(std::ptrdiff_t row) const {
    const auto width = static_cast<std::ptrdiff_t>(params.numbers->columns.size());
    return {params.numbers->values.data() + row * width, width};
  }
};

const TypeInfo* FindType(std::string_view name) {
  using namespace ros2;
  for (const TypeInfo* type :
       {&internal::TypeInfoOf<sensor_msgs::JointState>(), &internal::TypeInfoOf<sensor_msgs::Imu>(),
        &internal::TypeInfoOf<nav_msgs::Odometry>(), &internal::TypeInfoOf<geometry_msgs::WrenchStamped>(),
        &internal::TypeInfoOf<geometry_msgs::Twist>(), &internal::TypeInfoOf<sensor_msgs::Joy>()})
    if (NameOf(*type) == name) return type;
  return nullptr;
}

/// A text as the name of a block or an element.
std::string AsName(std::string text) {
  for (char& c : text)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  return text;
}

/// Names the numbers of a first message, without stamps and covariances. Joints have their names.
void Describe(const void* message, Numbers& numbers) {
  const std::vector<Element> all = internal::ListElements(*numbers.type, message, "message");
  numbers.scalars = all.size();
  std::vector<std::string> joints;
  if (numbers.type == &internal::TypeInfoOf<ros2::sensor_msgs::JointState>())
    joints = static_cast<const ros2::sensor_msgs::JointState*>(message)->name;
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::string name = all[i].name;
    if (name.starts_with("header.") || name.find("covariance") != name.npos) continue;
    const std::size_t dot = name.rfind('.');
    if (!joints.empty() && dot != name.npos) {
      const auto joint = static_cast<std::size_t>(std::stoul(name.substr(dot + 1)));
      if (joint < joints.size()) name = name.substr(0, dot + 1) + AsName(joints[joint]);
    }
    numbers.columns.push_back(i);
    numbers.elements += (numbers.elements.empty() ? "" : ",") + name;
  }
}

/// Reads the topics of a file.
class Log {
 public:
  void Read(const std::filesystem::path& file) {
    told_ = ReadMcap(file, [this](const McapMessage& message) { Take(message); });
  }
  /// Everything that is said about the file.
  std::vector<std::string> Told() const {
    std::vector<std::string> all;
    if (!told_.empty()) all.push_back(told_);
    for (const auto& [topic, type] : others_)
      all.push_back(fmt::format("the topic '{}' is not shown: its type is {}", internal::Excerpt(topic),
                                internal::Excerpt(type)));
    if (refused_ > 0)
      all.push_back(fmt::format("{} messages were refused, the last one: {}", refused_, why_));
    return all;
  }

  std::map<std::string, Numbers> topics;
  double begin = 0;  ///< time of the first message [s]
  long last = 0;     ///< last sample

 private:
  void Take(const McapMessage& message) {
    if (!began_) begin = message.time;
    began_ = true;
    const std::string name(message.topic);
    Numbers& to = topics[name];
    if (to.type == nullptr && (to.type = FindType(message.type)) == nullptr) {
      topics.erase(name);
      others_[name] = message.type;
      return;
    }
    internal::AnyValue value(*to.type, std::byte{0});
    if (const std::string reason = message.Read(*to.type, value.get()); !reason.empty())
      return Refuse(reason);
    if (to.scalars == 0) Describe(value.get(), to);
    if (internal::CountScalars(*to.type, value.get()) != to.scalars)
      return Refuse(fmt::format("topic '{}': another number of elements", internal::Excerpt(name)));
    if (internal::FinitenessOf(*to.type, value.get()) != internal::Finiteness::kFinite)
      return Refuse(
          fmt::format("topic '{}', t = {} s: a number is not finite", internal::Excerpt(name), message.time));
    const long sample = Topic::SampleAt(message.time - begin);
    if (sample < 0 || (!to.samples.empty() && sample < to.samples.back()))
      return Refuse(
          fmt::format("topic '{}', t = {} s: its time goes back", internal::Excerpt(name), message.time));
    if (to.samples.empty() || to.samples.back() < sample) {
      if ((count_ += to.columns.size()) > kMostNumbers) return Refuse("the file is too long for one report");
      to.samples.push_back(sample);
      to.values.resize(to.values.size() + to.columns.size());
    }
    row_.resize(to.scalars);
    internal::ToDoubles(*to.type, value.get(), row_.data());
    double* out = to.values.data() + to.values.size() - to.columns.size();
    for (const std::size_t column : to.columns) *out++ = row_[column];
    last = std::max(last, sample);
  }
  void Refuse(const std::string& why) {
    ++refused_;
    why_ = why;
  }

  std::string told_, why_;
  std::map<std::string, std::string> others_;
  std::vector<double> row_;
  std::size_t count_ = 0;
  long refused_ = 0;
  bool began_ = false;
};

}  // namespace

int ReportMcap(const std::filesystem::path& file, const std::filesystem::path& out) {
  Log log;
  log.Read(file);
  for (const std::string& told : log.Told()) Say(fmt::format("warning: {}\n", told));
  DiagramBuilder builder;
  std::vector<const Source*> signals;
  for (auto& [name, numbers] : log.topics) {
    if (numbers.samples.empty()) continue;
    const TopicParams params{std::make_shared<const Numbers>(std::move(numbers))};
    signals.push_back(
        &builder.Add<Topic>(AsName(name.substr(name.starts_with('/') ? 1 : 0)), params).message);
  }
  if (signals.empty())
    throw ParameterError(
        fmt::format("'{}' holds no messages to show: JointState, Imu, Odometry, "
                    "WrenchStamped, Twist or Joy in CDR",
                    internal::Excerpt(file.string())));
  const auto diagram = builder.Build();
  Simulator simulator(*diagram);
  Report report({.title = internal::Excerpt(file.filename().string()),
                 .description = fmt::format("MCAP from t = {:.3f} s on", log.begin),
                 .signal_rate = kRate});
  report.Log(simulator, signals);
  const OutputLock directory(out);
  simulator.AddLog(kRate, signals, {std::make_shared<CsvLog>(directory.path() / "signals.csv")});
  simulator.RunTo(static_cast<double>(log.last) / kRate.hz());
  report.Conclude(log.Told().empty(), log.Told().empty() ? "read as a whole" : log.Told().front());
  report.Write(directory.path() / "report.html");
  fmt::print("{}\n", (directory.path() / "report.html").string());
  return kRan;
}

}  // namespace tenon::apps
