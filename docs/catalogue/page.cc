#include <tenon/docs/catalogue/page.h>
#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/geometry.h>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <tuple>
#include <typeinfo>

namespace tenon::docs {
namespace {

using internal::TypeInfo;
using Kind = TypeInfo::Kind;

/// The name of a type, including aliases that the compiler cannot report.
std::string NameOf(const TypeInfo& type) {
  if (*type.id == typeid(CableVector)) return "CableVector";
  if (*type.id == typeid(ExternalForces)) return "ExternalForces";
  if (*type.id == typeid(Geometry)) return "Geometry";
  return internal::TypeName(type);
}

/// Formats one line of a table.
std::string Line(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += (cell.empty() ? "" : " " + cell) + " |";
  return line + "\n";
}

/// The type of the items of a list, an array or an optional; otherwise `type` itself.
const TypeInfo& ItemOf(const TypeInfo& type) {
  return type.item == nullptr ? type : ItemOf(type.item());
}

bool HasEntry(const TypeInfo& type) {
  return type.kind == Kind::kStruct || !type.names.empty();
}

/// Collects the types of ports, states and Parameters, and the types of their fields.
class Signals {
 public:
  explicit Signals(const std::map<std::string, Declaration>& declarations) : declarations_(declarations) {}

  /// Returns the type's name, with a link to its entry if it has one.
  std::string Link(const TypeInfo& type) {
    const TypeInfo& item = ItemOf(type);
    if (!HasEntry(item)) return fmt::format("`{}`", NameOf(type));
    Add(item);
    return fmt::format("[`{}`](#{})", NameOf(type), Anchor(item));
  }

  std::string Table() const {
    std::string table = "| type | field | | unit | range |\n| --- | --- | --- | --- | --- |\n";
    for (const auto& [name, rows] : entries_) table += rows;
    return table;
  }

 private:
  static std::string Anchor(const TypeInfo& type) {
    std::string anchor = "type-" + NameOf(type);
    std::replace_if(
        anchor.begin(), anchor.end(), [](unsigned char c) { return !std::isalnum(c); }, '-');
    return anchor;
  }

  void Add(const TypeInfo& type) {
    const auto [entry, is_new] = entries_.try_emplace(NameOf(type));
    if (!is_new) return;
    const std::string name = fmt::format("<a name=\"{}\"></a>{}", Anchor(type), Declared(entry->first));
    std::string rows;
    if (type.kind != Kind::kStruct) {
      for (const internal::NamedValue& value : type.names)
        rows += (rows.empty() ? "" : ", ") + std::string(value.name);
      rows = Line({name, rows, "", "", ""});
    }
    for (const Field& field : type.fields) {
      rows +=
          Line({rows.empty() ? name : "", field.name, Link(field.type()), field.units, field.range.Text()});
    }
    if (rows.empty()) rows = Line({name, "no numbers", "", "", ""});
    entries_[NameOf(type)] = rows;
  }

  /// Returns the name, with a link to the header that declares it.
  std::string Declared(const std::string& name) const {
    const auto declaration = declarations_.find(name.substr(0, name.find_first_of(":<")));
    if (declaration == declarations_.end()) return fmt::format("`{}`", name);
    return fmt::format("[`{}`](../{})", name, declaration->second.header);
  }

  const std::map<std::string, Declaration>& declarations_;
  std::map<std::string, std::string> entries_;
};

std::string Number(double number) {
  return fmt::format("{:.4g}", number);
}

/// Returns the units and element names of a signal, "m, m/s (position, velocity)".
std::string UnitOf(const Source& source) {
  const Spec& spec = source.spec();
  return spec.units + (spec.elements.empty() ? "" : fmt::format(" ({})", spec.elements));
}

/// The value of an optional input that is not connected, or of a Parameter.
std::string DefaultOf(const Source& source) {
  const TypeInfo& type = source.type();
  const std::vector<double> numbers = source.initial_numbers();
  if (numbers.empty()) return "empty";
  const bool zero = std::all_of(numbers.begin(), numbers.end(), [](double number) { return number == 0; });
  if (type.kind == Kind::kStruct && numbers.size() > 1 && !zero) {
    std::vector<std::string> fields;
    for (const Element& element : source.elements())
      fields.push_back(element.name + " " + Number(numbers[fields.size()]));
    return fmt::format("{}", fmt::join(fields, ", "));
  }
  for (const internal::NamedValue& value : type.names)
    if (static_cast<double>(value.value) == numbers[0]) return value.name;
  if (source.type_name() == "bool") return numbers[0] == 0 ? "false" : "true";
  if (zero) return "0";
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(numbers.size(), 3); ++i)
    text += (i == 0 ? "" : ", ") + Number(numbers[i]);
  return numbers.size() == 1 ? text : fmt::format("({}{})", text, numbers.size() > 3 ? ", …" : "");
}

/// Adds to `seen` all sources, including inputs of `block`, on whose present value `source` depends.
void FindInputs(const Source& source, const System& block, std::set<const Source*>& seen) {
  if (!seen.insert(&source).second) return;
  if (source.kind() == SourceKind::kInput && &source.owner() == &block) return;
  if (source.driver() != nullptr) return FindInputs(*source.driver(), block, seen);
  for (const Source* used : source.uses()) FindInputs(*used, block, seen);
}

std::string When(const Trigger& trigger) {
  switch (trigger.when) {
    case Trigger::When::kSampled:
      return Number(trigger.sampled.rate.hz()) + " Hz";
    case Trigger::When::kEachStep:
      return "after each step";
    case Trigger::When::kAtStart:
      return "at the start";
    case Trigger::When::kWitness:
      return "at an event";
    case Trigger::When::kAlways:
      break;
  }
  return "continuous";
}

/// One line in the table of a block.
struct Row {
  std::string name, type, unit;
  std::string kind = {}, when = {}, follows = {};
  bool optional = false;
  bool AlikeBut(const Row& other) const {
    return std::tie(kind, type, unit, when, optional) ==
           std::tie(other.kind, other.type, other.unit, other.when, other.optional);
  }
};

/// Splits "u_0" into "u" and 0; -1 if the name has no number.
std::pair<std::string, int> SplitNumber(const std::string& name) {
  const std::size_t line = name.rfind('_');
  const bool numbered = line != std::string::npos && line + 1 < name.size() &&
                        std::all_of(name.begin() + static_cast<std::ptrdiff_t>(line) + 1, name.end(),
                                    [](unsigned char c) { return std::isdigit(c); });
  if (!numbered) return {name, -1};
  return {name.substr(0, line), std::stoi(name.substr(line + 1))};
}

class BlockTable {
 public:
  BlockTable(const Entry& entry, Signals& signals) : entry_(entry), signals_(signals) {
    for (const SourceKind kind : {SourceKind::kInput, SourceKind::kOutput, SourceKind::kContinuous,
                                  SourceKind::kDiscrete, SourceKind::kMonitor}) {
      for (const Source* source : entry.block->sources()) {
        if (source->kind() == kind) Add(*source);
      }
    }
    for (const Source* source : entry.block->sources()) {
      if (source->kind() != SourceKind::kParameter) continue;
      if (parameters_.empty())
        parameters_ =
            "\n| parameter | type | unit | range | default | |\n| --- | --- | --- | --- | --- | --- |\n";
      const auto& parameter = static_cast<const internal::ParameterSource&>(*source);
      parameters_ += Line({source->name(), TypeOf(*source), UnitOf(*source), parameter.range().Text(),
                           DefaultOf(*source), parameter.description()});
    }
  }

  std::string Text() const {
    if (rows_.empty()) return "This block has no ports.\n" + parameters_;
    std::string text = "| | | type | unit | when | feedthrough |\n| --- | --- | --- | --- | --- | --- |\n";
    for (const Row& row : rows_) {
      text += Line({row.optional ? "*" + row.name + "*" : row.name, row.kind, row.type, row.unit, row.when,
                    row.follows});
    }
    return text + parameters_;
  }

 private:
  void Add(const Source& source) {
    Row row{.name = source.name(), .type = TypeOf(source), .unit = UnitOf(source)};
    switch (source.kind()) {
      case SourceKind::kInput:
        row.optional = source.is_optional();
        row.kind = row.optional ? "in, else " + DefaultOf(source) : "in";
        break;
      case SourceKind::kOutput:
        row.kind = "out";
        row.when = When(source.Resolve().trigger());
        row.follows = Follows(source);
        break;
      case SourceKind::kContinuous:
        row.kind = "continuous state";
        break;
      case SourceKind::kDiscrete:
        row.kind = "discrete state";
        row.when = UpdatesOf(source);
        break;
      default:
        row.kind = "ends the run";
        row.type = row.unit = "";
        row.when = When(source.trigger());
    }
    if (!rows_.empty()) {
      // The ports of a list share one line.
      const auto [list, number] = SplitNumber(row.name);
      const auto [last, last_number] = SplitNumber(rows_.back().name.substr(0, rows_.back().name.find(',')));
      if (number > 0 && last == list && rows_.back().AlikeBut(row)) {
        rows_.back().name = fmt::format("{0}_0, {0}_1, …", list);
        return;
      }
    }
    rows_.push_back(row);
  }

  std::string TypeOf(const Source& source) {
    std::string name = source.type_name();
    for (const auto& [type, placeholder] : entry_.placeholders) {
      const std::size_t at = name.find(type);
      if (at != name.npos) return fmt::format("`{}`", name.replace(at, type.size(), placeholder));
    }
    return signals_.Link(source.type());
  }

  /// Names of the inputs that affect the output without delay.
  std::string Follows(const Source& output) const {
    std::set<const Source*> seen;
    FindInputs(output, *entry_.block, seen);
    std::vector<std::string> names;
    for (const Row& row : rows_) {
      const auto is_row = [&](const Source* source) {
        return source->kind() == SourceKind::kInput && &source->owner() == entry_.block.get() &&
               (source->name() == row.name || row.name.starts_with(source->name() + ","));
      };
      if (std::any_of(seen.begin(), seen.end(), is_row)) names.push_back(row.name);
    }
    return fmt::format("{}", fmt::join(names, ", "));
  }

  std::string UpdatesOf(const Source& state) const {
    std::vector<std::string> times;
    for (const Source* source : entry_.block->sources()) {
      if (source->kind() == SourceKind::kUpdate && source->target() == &state) {
        times.push_back(When(source->trigger()));
      }
    }
    return fmt::format("{}", fmt::join(times, ", "));
  }

  const Entry& entry_;
  Signals& signals_;
  std::vector<Row> rows_;
  std::string parameters_;  ///< table of the Parameters, empty without any
};

std::string Section(const Entry& entry, const std::map<std::string, Declaration>& declarations,
                    Signals& signals) {
  const auto declaration = declarations.find(entry.name);
  if (declaration == declarations.end()) {
    throw Error(fmt::format("the class '{}' of the catalogue is in no public header", entry.name));
  }
  // In Markdown, <T> in a heading would be an HTML tag.
  const std::string heading = entry.title.substr(0, entry.title.find('<'));
  return fmt::format("### {}\n\n[`{}`](../{}): {}{}\n\n{}", heading, entry.title, declaration->second.header,
                     declaration->second.summary, entry.note.empty() ? "" : " " + entry.note,
                     BlockTable(entry, signals).Text());
}

void Replace(std::string& text, const std::string& what, const std::string& by) {
  const std::size_t place = text.find(what);
  if (place == std::string::npos) throw Error(fmt::format("the template has no line '{}'", what));
  text.replace(place, what.size(), by);
}

}  // namespace

std::string WritePage(const std::string& text, const std::vector<Shelf>& catalogue,
                      const std::map<std::string, Declaration>& declarations) {
  Signals signals(declarations);
  std::string page = text;
  for (const Shelf& shelf : catalogue) {
    std::string sections;
    for (const Entry& entry : shelf.entries) {
      if (!sections.empty()) sections += "\n";
      sections += Section(entry, declarations, signals);
    }
    Replace(page, "{{" + shelf.name + "}}\n", sections);
  }
  Replace(page, "{{signals}}\n", signals.Table());
  return page;
}

}  // namespace tenon::docs
