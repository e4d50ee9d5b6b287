#include <tenon/systems/framework/diagram/diagram.h>

#include <fmt/core.h>

namespace tenon {
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
    for (const auto& block : blocks) {
      for (const Source* source : block->sources()) {
        if (source->is_sampled()) periods_.try_emplace(source->trigger().sampled.rate.period(), "");
      }
      if (const auto* nested = dynamic_cast<const Subdiagram*>(block.get())) FindPeriods(nested->blocks());
    }
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
    for (const auto& block : blocks) {
      const auto* nested = dynamic_cast<const Subdiagram*>(block.get());
      for (const Source* port : block->sources()) {
        if (!IsPort(*port) || port->driver() == nullptr || !IsPort(*port->driver())) continue;
        out_ += fmt::format("  {} -> {};\n", End(*port->driver(), "e"), End(*port, "w"));
      }
      if (nested != nullptr) DrawConnections(nested->blocks());
    }
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
