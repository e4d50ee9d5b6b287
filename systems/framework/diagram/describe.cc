#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>

#include <fmt/core.h>

#include <iterator>

namespace tenon {
namespace {

using internal::CalculationInfo;
using internal::Program;

/// The class of a block as written in code, without Tenon's namespaces.
std::string ClassName(const System& block) {
  std::string text = internal::Demangled(typeid(block).name());
  for (const std::string ours : {"tenon::", "(anonymous namespace)::", "internal::"}) {
    for (std::size_t at; (at = text.find(ours)) != std::string::npos;) text.erase(at, ours.size());
  }
  constexpr std::size_t kLongest = 60;  // blocks made by AddFunction are named after their lambdas
  return text.size() > kLongest ? text.substr(0, text.find('<')) : text;
}

std::string Units(const Source& source) {
  return source.spec().units.empty() ? "" : fmt::format(" [{}]", source.spec().units);
}

std::string When(const Source& source) {
  const Trigger& trigger = source.trigger();
  switch (trigger.when) {
    case Trigger::When::kAlways:
      return "";
    case Trigger::When::kSampled: {
      const double offset = trigger.sampled.offset;
      const std::string from = offset > 0 ? fmt::format(" from {:g} ms", offset * 1000) : "";
      return fmt::format(", every {:g} ms{}", trigger.sampled.rate.period() * 1000, from);
    }
    case Trigger::When::kEachStep:
      return ", after each step";
    case Trigger::When::kAtStart:
      return ", at the start";
    case Trigger::When::kWitness:
      return fmt::format(", when '{}' crosses zero", trigger.witness->name());
  }
  return "";
}

/// Names of the kinds, in the order of SourceKind.
constexpr const char* kKindNames[] = {"input",          "output",    "continuous state", "derivative",
                                      "discrete state", "parameter", "update",           "shared",
                                      "scratch",        "workspace", "random",           "witness",
                                      "kink",           "next jump", "monitor",          "publish"};
static_assert(std::size(kKindNames) == static_cast<std::size_t>(SourceKind::kPublish) + 1);

class Description {
 public:
  explicit Description(const Program& program) : program_(program) {}

  std::string Write(const std::vector<std::unique_ptr<System>>& blocks) {
    text_ = "Blocks\n";
    WriteBlocks(blocks, "  ");
    WriteTicks();
    WriteIntegration();
    return text_;
  }

 private:
  void WriteBlocks(const std::vector<std::unique_ptr<System>>& blocks, const std::string& indent) {
    for (const auto& block : blocks) {
      text_ += fmt::format("{}{}: {}\n", indent, block->name(), ClassName(*block));
      for (const Source* source : block->sources()) {
        if (source->kind() == SourceKind::kDerivative) continue;
        std::string from;
        if (source->driver() != nullptr) from = fmt::format(" <- {}", source->driver()->path());
        const bool open = source->kind() == SourceKind::kInput && source->driver() == nullptr;
        if (open) from = source->is_optional() ? ", has a default" : ", open";
        text_ +=
            fmt::format("{}  {} {}: {}{}{}{}\n", indent, kKindNames[static_cast<std::size_t>(source->kind())],
                        source->name(), source->type_name(), Units(*source), When(*source), from);
      }
      if (const auto* nested = dynamic_cast<const Subdiagram*>(block.get()))
        WriteBlocks(nested->blocks(), indent + "  ");
    }
  }

  void WriteTicks() {
    if (program_.groups.empty()) return;
    text_ += "Ticks\n";
    for (std::size_t i = 0; i < program_.groups.size(); ++i) {
      const internal::SampleGroup& group = program_.groups[i];
      const double period = 1000.0 * static_cast<double>(group.period.numerator) /
                            static_cast<double>(group.period.denominator),
                   offset = 1000.0 * static_cast<double>(group.offset.numerator) /
                            static_cast<double>(group.offset.denominator);
      text_ +=
          fmt::format("  every {:g} ms{}{}\n", period, offset > 0 ? fmt::format(" from {:g} ms", offset) : "",
                      group.feeds ? ", restarts the integrator" : ", does not restart the integrator");
      const internal::TickPlan plan = program_.MakeTick({static_cast<int>(i)});
      WriteOps("computes", plan.outputs);
      WriteOps("monitors", plan.monitors);
      WriteOps("updates", plan.updates.ops);
    }
    if (program_.groups.size() < 2) return;
    internal::Groups all;
    for (std::size_t i = 0; i < program_.groups.size(); ++i) all.push_back(static_cast<int>(i));
    text_ += "  all together\n";
    WriteOps("computes", program_.MakeTick(all).outputs);
  }

  void WriteIntegration() {
    if (program_.num_continuous == 0) return;
    text_ += fmt::format("Integration of {} states\n", program_.num_continuous);
    WriteOps("before", program_.held);
    WriteOps("at each stage", program_.derivatives.ops);
    WriteOps("detects zero crossings of", program_.witnesses.ops);
    WriteOps("after each step", program_.each_step.ops);
    WriteOps("monitors after each step", program_.each_step_monitors);
    std::string restarts;
    for (const CalculationInfo& info : program_.calculations) {
      const Source& source = *info.source;
      if (!info.feeds || source.trigger().when == Trigger::When::kAlways) continue;
      if (source.kind() == SourceKind::kOutput || source.kind() == SourceKind::kUpdate)
        restarts += fmt::format("{}{}", restarts.empty() ? "" : ", ", source.path());
    }
    if (!restarts.empty()) text_ += fmt::format("  restarts after: {}\n", restarts);
  }

  void WriteOps(const char* what, const internal::OpList& ops) {
    if (ops.empty()) return;
    text_ += fmt::format("    {}: ", what);
    for (const internal::Op& op : ops) {
      text_ += fmt::format("{}{}", &op == ops.data() ? "" : ", ",
                           program_.calculations[op.calculation].source->path());
    }
    text_ += '\n';
  }

  const Program& program_;
  std::string text_;
};

}  // namespace

std::string Diagram::Describe() const {
  return Description(*program_).Write(blocks_);
}

namespace {

/// Colours of sample times, fastest first; blocks without sample time are white.
constexpr const char* kColours[] = {"#f4b6b6", "#f7d9a8", "#f5f1a6", "#c5e6b4",
                                    "#b5e0e6", "#bcc9f0", "#dcc3ec"};

class Drawing {
 public:
  std::string Draw(const std::vector<std::unique_ptr<System>>& blocks) {
    FindPeriods(blocks);
    out_ =
        "digraph diagram {\n  rankdir=LR; fontname=\"Helvetica\";\n"
        "  node [shape=plain, fontname=\"Helvetica\", fontsize=11];\n"
        "  edge [fontname=\"Helvetica\", fontsize=9, arrowsize=0.7];\n";
    DrawBlocks(blocks, "  ");
    DrawConnections(blocks);
    DrawLegend();
    return out_ + "}\n";
  }

 private:
  static bool IsPort(const Source& source) {
    return source.kind() == SourceKind::kInput || source.kind() == SourceKind::kOutput;
  }

  void FindPeriods(const std::vector<std::unique_ptr<System>>& blocks) {
    internal::ForEachBlock(blocks, [this](const System& block) {
      for (const Source* source : block.sources())
        if (source->is_sampled()) periods_.try_emplace(source->trigger().sampled.rate.period(), "");
    });
    std::size_t i = 0;
    for (auto& [period, colour] : periods_) colour = kColours[std::min(i++, std::size(kColours) - 1)];
  }

  std::string Cell(const Source& port, const char* align) const {
    const std::string colour =
        port.is_sampled() ? fmt::format(" bgcolor=\"{}\"", periods_.at(port.trigger().sampled.rate.period()))
                          : "";
    return fmt::format("<tr><td port=\"{0}\" align=\"{1}\"{2}>{0}</td></tr>", port.name(), align, colour);
  }

  void DrawBlocks(const std::vector<std::unique_ptr<System>>& blocks, const std::string& indent) {
    constexpr std::size_t kMaxDepth = 100;  // the size of the text grows with the square of the depth
    if (indent.size() > 2 * kMaxDepth)
      throw Error(fmt::format("diagrams that are nested more than {} deep cannot be drawn", kMaxDepth));
    for (const auto& block : blocks) {
      if (const auto* nested = dynamic_cast<const Subdiagram*>(block.get())) {
        out_ += fmt::format(
            "{0}subgraph \"cluster_{1}\" {{\n{0}  label=\"{2}\"; style=rounded; color=\"#888888\";\n", indent,
            block->path(), block->name());
        // Ports of a nested diagram are drawn as nodes on its border.
        for (const Source* port : block->sources()) {
          out_ += fmt::format("{}  \"{}\" [shape=cds, label=\"{}\", fontsize=9];\n", indent, port->path(),
                              port->name());
        }
        DrawBlocks(nested->blocks(), indent + "  ");
        out_ += indent + "}\n";
        continue;
      }
      std::string inputs, outputs;
      for (const Source* source : block->sources()) {
        if (source->kind() == SourceKind::kInput) inputs += Cell(*source, "left");
        if (source->kind() == SourceKind::kOutput) outputs += Cell(*source, "right");
      }
      const auto column = [](const std::string& cells) {
        return cells.empty()
                   ? std::string()
                   : "<td><table border=\"0\" cellborder=\"0\" cellspacing=\"1\">" + cells + "</table></td>";
      };
      out_ += fmt::format(
          "{}\"{}\" [label=<<table border=\"1\" cellborder=\"0\" cellspacing=\"0\" style=\"rounded\"><tr><td "
          "colspan=\"2\"><b>{}</b></td></tr><tr>{}{}</tr></table>>];\n",
          indent, block->path(), block->name(), column(inputs),
          inputs.empty() && outputs.empty() ? "<td></td>" : column(outputs));
    }
  }

  static std::string End(const Source& port, const char* side) {
    if (dynamic_cast<const Subdiagram*>(&port.owner()) != nullptr) return fmt::format("\"{}\"", port.path());
    return fmt::format("\"{}\":\"{}\":{}", port.owner().path(), port.name(), side);
  }

  void DrawConnections(const std::vector<std::unique_ptr<System>>& blocks) {
    internal::ForEachBlock(blocks, [this](const System& block) {
      for (const Source* port : block.sources()) {
        if (!IsPort(*port) || port->driver() == nullptr || !IsPort(*port->driver())) continue;
        out_ += fmt::format("  {} -> {};\n", End(*port->driver(), "e"), End(*port, "w"));
      }
    });
  }

  void DrawLegend() {
    if (periods_.empty()) return;
    std::string rows = "<tr><td><b>sample time</b></td></tr>";
    for (const auto& [period, colour] : periods_) {
      rows += fmt::format("<tr><td bgcolor=\"{}\">{:g} ms</td></tr>", colour, period * 1000);
    }
    out_ += fmt::format(
        "  legend [label=<<table border=\"0\" cellborder=\"1\" cellspacing=\"0\">{}</table>>];\n", rows);
  }

  std::map<double, std::string> periods_;
  std::string out_;
};

}  // namespace

std::string Diagram::Graphviz() const {
  return Drawing().Draw(blocks_);
}

}  // namespace tenon
