#include <tenon/apps/common/figure_text.h>
#include <tenon/apps/common/outputs.h>
#include <tenon/apps/common/verdicts.h>

#include <fmt/core.h>

#include <numbers>

namespace tenon::apps {
namespace {

/// Collects the only column of a log from a time on.
class TallySink final : public LogSink {
 public:
  explicit TallySink(double from) : from_(from) {}
  void Begin(const std::vector<std::string>&, const std::vector<std::string>&) override {}
  void Row(std::span<const double> row) override {
    if (row[0] >= from_) tally_.Add(row[1]);
  }
  const Tally& tally() const { return tally_; }

 private:
  double from_;
  Tally tally_;
};

std::vector<std::string> PathsOf(const std::vector<const Source*>& signals) {
  std::vector<std::string> paths;
  for (const Source* signal : signals) paths.push_back(signal->path());
  return paths;
}

struct ArrowParams {
  std::string name;
  ShapeRole role;
  double scale;
};

/// Draws one arrow.
class ArrowBlock final : public LeafSystem<ArrowParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<Vec<3>> point_W{this, {"point_W"}};
  InputPort<Vec<3>> vector_W{this, {"vector_W"}};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                Geometry{Shape::Arrow(params.role, params.name, params.scale)},
                                Uses(point_W, vector_W),
                                &ArrowBlock::CalcGeometry};

 private:
  void CalcGeometry(const Vec<3>& point_W, const Vec<3>& vector_W, Geometry* geometry) const {
    geometry->front().p_W = point_W;
    geometry->front().vector_W = vector_W;
  }
};

}  // namespace

void Outputs::Arrow(std::string name, ShapeRole role, const OutputPort<Vec<3>>& point_W,
                    const OutputPort<Vec<3>>& vector_W, double scale) {
  auto& arrow = builder_.Add<ArrowBlock>(fmt::format("arrow_{}", shapes_.size()),
                                         ArrowParams{std::move(name), role, scale});
  builder_.Connect(point_W, arrow.point_W);
  builder_.Connect(vector_W, arrow.vector_W);
  Show(arrow.geometry);
}

void Outputs::Plot(std::string title, std::vector<const Source*> signals,
                   std::vector<const Source*> references) {
  for (const auto* list : {&signals, &references})
    signals_.insert(signals_.end(), list->begin(), list->end());
  plots_.push_back({std::move(title), std::move(signals), std::move(references)});
}

void Outputs::Figure(std::string key, const OutputPort<double>& signal, Statistic statistic, double from) {
  const auto sink = std::make_shared<TallySink>(from);
  Judge(Hz(1000), {&signal}, sink, [key = std::move(key), sink, statistic](Summary& summary) {
    summary.Set(key, (sink->tally().*statistic)());
  });
}

void Outputs::Judge(Rate rate, std::vector<const Source*> signals, std::shared_ptr<LogSink> sink,
                    std::function<void(Summary&)> judge) {
  judged_.push_back({rate, std::move(signals), std::move(sink), std::move(judge)});
}

void Outputs::AddTo(Simulator& simulator) const {
  for (const Judged& judged : judged_) simulator.AddLog(judged.rate, judged.signals, {judged.sink});
}

void Outputs::AddTo(Summary& summary) const {
  for (const Judged& judged : judged_) judged.judge(summary);
}

void Outputs::AddTo(std::vector<const Source*>& signals,
                    std::vector<const OutputPort<Geometry>*>& shapes) const {
  const auto add = [](const auto& own, auto& list) {
    for (const auto* item : own)
      if (std::ranges::find(list, item) == list.end()) list.push_back(item);
  };
  add(signals_, signals);
  add(shapes_, shapes);
}

std::vector<tenon::Plot> Outputs::plots() const {
  std::vector<tenon::Plot> plots;
  for (const auto& [title, signals, references] : plots_)
    plots.push_back({.title = title, .signals = PathsOf(signals), .references = PathsOf(references)});
  return plots;
}

PathVerdict::PathVerdict(double tolerance, double length, double offset, double turned)
    : judged_(true), heading_limit_(tolerance * std::numbers::pi + turned) {
  if (length > 0) position_limit_ = tolerance * length + offset;
}

void PathVerdict::Add(double time, double deviation, double turn) {
  if (!judged_) return;
  turn = std::abs(std::remainder(turn, 2 * std::numbers::pi));
  deviations_.Add(deviation);
  turns_.Add(turn);
  if (!left_ && position_limit_ && deviation > *position_limit_) left_ = time;
  if (!turned_ && turn > *heading_limit_) turned_ = time;
}

void PathVerdict::AddTo(Summary& summary) const {
  summary.SetFollowed(deviations_.max() ? std::optional(!left_ && !turned_) : std::nullopt);
  summary.Set("path_deviation_max_m", deviations_.max(), {.high = position_limit_});
  summary.Set("heading_deviation_max_rad", turns_.max(), {.high = heading_limit_});
  if (left_) {
    const auto [worst, limit] = Beside(*deviations_.max(), *position_limit_);
    summary.Break(*left_, fmt::format("the path was not followed: the robot left it by {} m, more than {} m",
                                      worst, limit));
  }
  if (turned_) {
    const auto [worst, limit] = Beside(*turns_.max(), *heading_limit_);
    summary.Break(*turned_,
                  fmt::format("the path was not followed: the heading deviated by {} rad, more than "
                              "{} rad",
                              worst, limit));
  }
}

void TaskBounds::Validate() const {
  if (at_least && at_most && *at_least > *at_most)
    throw ParameterError(fmt::format("at_least = {} must not be above at_most = {}", *at_least, *at_most));
}

void Task::AddTo(Summary& summary, double due) const {
  for (const auto& [key, bounds] : figures)
    summary.Require(key, {.low = bounds.at_least, .high = bounds.at_most}, due_s.value_or(due));
}

}  // namespace tenon::apps
