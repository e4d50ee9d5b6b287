#include <tenon/apps/common/outputs.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

/// Collects the only column of a log from a time on.
class TallySink final : public LogSink {
 public:
  explicit TallySink(double from) : from_(from) {}
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

}  // namespace tenon::apps
