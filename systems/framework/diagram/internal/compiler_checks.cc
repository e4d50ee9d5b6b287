#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/diagram/internal/compiler.h>

#include <fmt/core.h>

#include <set>
#include <tuple>

namespace tenon::internal {
namespace {

/// The type to which a Spec applies: for arrays and lists the type of their innermost items.
const TypeInfo& Innermost(const TypeInfo& type) {
  const TypeInfo* inner = &type;
  while (inner->kind == TypeInfo::Kind::kArray || inner->kind == TypeInfo::Kind::kList ||
         inner->kind == TypeInfo::Kind::kOptional) {
    inner = &inner->item();
  }
  return *inner;
}

bool UnitsAgree(const Spec& a, const Spec& b) {
  if (a.units == b.units) return true;
  const std::size_t count = std::max(ListLength(a.units), ListLength(b.units));
  for (std::size_t i = 0; i < count; ++i) {
    const std::string x = ElementUnit(a, i), y = ElementUnit(b, i);
    if (!x.empty() && !y.empty() && x != y) return false;
  }
  return true;
}

/// True for members that are named by their block and appear in logs. Derivatives and updates take the names
/// of their states.
bool HasOwnName(const Source& source) {
  return source.kind() != SourceKind::kDerivative && source.kind() != SourceKind::kUpdate;
}

}  // namespace

void Compiler::Fault(std::string text) {
  faults_.push_back(std::move(text));
}

void Compiler::ThrowFaults() const {
  if (faults_.empty()) return;
  if (faults_.size() == 1) throw BuildError(faults_[0]);
  std::string text = fmt::format("the diagram has {} faults:", faults_.size());
  for (const std::string& fault : faults_) text += "\n  " + fault;
  throw BuildError(text);
}

void Compiler::CheckMembers(const System& block) {
  std::vector<const Source*> members;
  members.reserve(block.sources().size());
  for (const Source* source : block.sources()) {
    if (!HasOwnName(*source)) continue;
    CheckSpec(*source);
    // An output that shows a state may have the state's name.
    const bool shown = source->kind() == SourceKind::kOutput && source->driver() != nullptr &&
                       &source->driver()->owner() == &block && source->name() == source->driver()->name() &&
                       source->driver()->kind() != SourceKind::kInput &&
                       source->driver()->kind() != SourceKind::kOutput;
    if (!shown) members.push_back(source);
  }
  std::ranges::sort(members, {}, &Source::name);
  for (std::size_t i = 1; i < members.size(); ++i) {
    if (members[i]->name() != members[i - 1]->name()) continue;
    Fault(fmt::format("two members of '{}' are named '{}': give one of them another name", block.path(),
                      members[i]->name()));
  }
}

void Compiler::CheckSpec(const Source& source) {
  if (source.name().empty() || source.name().find_first_of(". \t\n,\"'") != std::string::npos) {
    Fault(fmt::format(
        "a member of '{}' cannot be named '{}': give a name without dots, commas, blanks and quotes",
        source.owner().path(), source.name()));
  }
  const Spec& spec = source.spec();
  if (spec.units.empty() && spec.elements.empty()) return;
  const TypeInfo& type = Innermost(*source.type_);
  std::size_t size = 1;
  switch (type.kind) {
    case TypeInfo::Kind::kNumber:
      break;
    case TypeInfo::Kind::kMatrix:
      if (type.shape == nullptr) {
        size = static_cast<std::size_t>(type.rows) * static_cast<std::size_t>(type.cols);
      } else if (&type == source.type_) {
        const Extents shape = ExtentsOf(type, source.model_);
        if (shape.rows == 0) return;  // the size is known only at run time
        size = shape.rows * shape.cols;
      } else {
        return;
      }
      break;
    case TypeInfo::Kind::kStruct:
      Fault(fmt::format("'{}' is a {}, which brings its own units and names: remove those of the port",
                        source.path(), source.type_name()));
      return;
    default:
      return;
  }
  const bool is_array = source.type_->kind == TypeInfo::Kind::kArray;
  const std::size_t units = ListLength(spec.units), names = ListLength(spec.elements),
                    named = is_array ? source.type_->count : size;
  if (units > 1 && units != size) {
    Fault(fmt::format("'{}' has {} elements but {} units ({}): give one for all, or one for each",
                      source.path(), size, units, spec.units));
  }
  if (names > 0 && names != named) {
    Fault(fmt::format("'{}' has {} {} but {} names ({}): give one for each", source.path(), named,
                      is_array ? "items" : "elements", names, spec.elements));
  }
}

void Compiler::CheckConnections() {
  const auto check = [&](const Source& to) {
    // Find the next port upstream with a unit: an empty unit is compatible with any.
    const Source* from = &to;
    bool ignored = false;
    do {
      ignored |= from->ignores_units_;
      from = from->driver_;
    } while (from->spec().units.empty() && from->driver_ != nullptr);
    if (!ignored && !to.spec().units.empty() && !UnitsAgree(from->spec(), to.spec())) {
      Fault(fmt::format(
          "'{}' [{}] is connected to '{}' [{}]: convert it by a block (a Gain, say), correct one of the "
          "units, or connect with IgnoreUnits{{}}",
          from->path(), from->spec().units, to.path(), to.spec().units));
    }
    if (to.type_->kind != TypeInfo::Kind::kMatrix || to.type_->shape == nullptr) return;
    const Source& origin = to.Resolve();
    const Extents given = ExtentsOf(*origin.type_, origin.model_), wanted = ExtentsOf(*to.type_, to.model_);
    if (given == wanted || given.rows * given.cols == 0 || wanted.rows * wanted.cols == 0) return;
    Fault(fmt::format("'{}' has {} x {} elements, but '{}' is declared with {} x {}: make them equal",
                      origin.path(), given.rows, given.cols, to.path(), wanted.rows, wanted.cols));
  };
  for (const Source* source : sources_) {
    if (source->kind() == SourceKind::kInput && source->driver_ != nullptr) check(*source);
  }
  for (const Source* port : ports_) {
    if (port->driver_ != nullptr) check(*port);
  }
}

/// Reports all ports that a replacing block lacks, in one fault.
void Compiler::CheckReplacement(const System& block) {
  std::string text;
  const auto add = [&](const std::string& difference) { text += (text.empty() ? "" : "; ") + difference; };
  const auto final = [](const System* system) {
    while (system->replaced_by_ != nullptr) system = system->replaced_by_;
    return system;
  };
  const auto describe_other = [&](const Source& port) {
    for (const Source* own : block.sources_) {
      if (own->kind() == port.kind() && own->name() == port.name())
        return fmt::format(" (its '{}' is a {})", own->name(), own->type_name());
    }
    return std::string();
  };
  for (const auto* list : {&sources_, &ports_}) {
    for (const Source* reader : *list) {
      const Source* driver = reader->driver_;
      if (driver == nullptr || driver->kind() != SourceKind::kOutput || &driver->owner() == &block ||
          final(&driver->owner()) != &block) {
        continue;
      }
      add(fmt::format("it lacks the output '{}' ({}){}, which '{}' reads", driver->name(),
                      driver->type_name(), describe_other(*driver), reader->path()));
    }
  }
  bool unused = false;  // true if an unconnected input may be the renamed port
  for (const Source* input : block.sources_) {
    if (input->kind() != SourceKind::kInput || input->driver_ != nullptr) continue;
    unused = true;
    if (!input->has_initial_value_ && !open_inputs_)
      add(fmt::format("nothing is connected to its input '{}' ({})", input->name(), input->type_name()));
  }
  for (const Source* old : block.replaces_->sources_) {
    if (!unused || old->kind() != SourceKind::kInput || old->driver_ == nullptr) continue;
    const bool matched = std::any_of(block.sources_.begin(), block.sources_.end(), [&](const Source* own) {
      return own->kind() == SourceKind::kInput && own->name() == old->name() &&
             *own->type_->id == *old->type_->id;
    });
    if (!matched) {
      add(fmt::format("it lacks the input '{}' ({}){}, which was connected to '{}'", old->name(),
                      old->type_name(), describe_other(*old), old->driver_->path()));
    }
  }
  if (text.empty()) return;
  Fault(
      fmt::format("the block that replaced '{}' has other ports: {}. Connect these ports, or Disconnect them",
                  block.path(), text));
}

void Compiler::ResolveInputs() {
  std::vector<const Source*>& open = program_.open_inputs;
  // Ports of subdiagrams, even without readers, can be set, evaluated and logged.
  std::vector<const Source*> ports(sources_.begin(), sources_.end());
  ports.insert(ports.end(), ports_.begin(), ports_.end());
  for (const Source* source : ports) {
    const Source& origin = source->Resolve();
    if (origin.kind() == SourceKind::kOutput && origin.run_ == nullptr) {
      Fault(fmt::format(
          "output '{}' of a nested diagram has nothing connected to it inside: connect an inner output to it",
          origin.path()));
      continue;
    }
    if (origin.kind() != SourceKind::kInput) continue;
    if (origin.has_initial_value_) {
      // Several inner inputs may share one port of a subdiagram.
      if (std::ranges::count(default_inputs_, &origin) == 0) default_inputs_.push_back(&origin);
      continue;
    }
    if (std::ranges::count(open, &origin) > 0) continue;
    open.push_back(&origin);
    if (!open_inputs_ && origin.owner().replaces_ == nullptr) {  // already reported
      const std::string through = &origin == source ? "" : fmt::format(" (it feeds '{}')", source->path());
      Fault(fmt::format(
          "input '{}' is not connected{}: connect an output to it, or give the port a default value",
          origin.path(), through));
    }
  }
}

void Compiler::CheckDeclarations() {
  std::unordered_map<const Source*, const Source*> derivatives, sampled_updates, scratch_users;
  std::set<std::tuple<const Source*, Trigger::When, const Witness*>> triggers;
  for (const Source* source : sources_) {
    if (source->run_ != nullptr) CheckArguments(*source);
    if (source->kind() == SourceKind::kDerivative && !derivatives.emplace(source->target_, source).second) {
      Fault(fmt::format("state '{}' has two time derivatives: remove one", source->target_->path()));
    }
    if (source->kind() == SourceKind::kUpdate && source->is_sampled() &&
        !sampled_updates.emplace(source->target_, source).second) {
      Fault(fmt::format("state '{}' has two sampled updates: merge them into one", source->target_->path()));
    }
    if (source->kind() == SourceKind::kUpdate &&
        !triggers.emplace(source->target_, source->trigger().when, source->trigger().witness).second) {
      Fault(fmt::format("state '{}' has two updates with the same trigger: merge them into one",
                        source->target_->path()));
    }
    if (source->kind() == SourceKind::kOutput && source->run_ != nullptr && source->is_sampled() &&
        source->trigger().sampled.offset > 0 && !source->has_initial_value_) {
      Fault(fmt::format(
          "sampled output '{}' first runs at t = {} s but has no initial value: declare one before Sampled",
          source->path(), double{source->trigger().sampled.offset}));
    }
    if (source->kind() == SourceKind::kOutput && source->run_ != nullptr && source->has_initial_value_ &&
        source->type_->kind == TypeInfo::Kind::kMatrix && CountScalars(*source->type_, source->model_) == 0) {
      Fault(
          fmt::format("the initial value of sampled output '{}' is empty, so that its first values have no "
                      "elements: give it (`initial`) the size of the signal",
                      source->path()));
    }
    for (const Slot& slot : source->arguments_) {
      if (slot.source == nullptr) continue;
      const SourceKind kind = slot.source->kind();
      if ((kind == SourceKind::kScratch || kind == SourceKind::kWorkspace) &&
          !scratch_users.emplace(slot.source, source).second) {
        Fault(fmt::format("{} '{}' is used by both '{}' and '{}': it belongs to one calculation",
                          kind == SourceKind::kScratch ? "scratch" : "workspace", slot.source->path(),
                          scratch_users[slot.source]->name(), source->name()));
      }
    }
  }
  for (const Source* source : sources_) {
    if (source->kind() != SourceKind::kContinuous) continue;
    if (!derivatives.contains(source)) {
      Fault(fmt::format("continuous state '{}' has no time derivative: declare a TimeDerivative",
                        source->path()));
    }
    if (source->type_->fixed && source->type_->num_scalars * sizeof(double) != source->type_->size) {
      Fault(fmt::format("continuous state '{}' has members other than doubles: list all members in Fields()",
                        source->path()));
    }
  }
}

void Compiler::CheckArguments(const Source& calculation) {
  for (const Slot& slot : calculation.arguments_) {
    if (slot.source == nullptr) continue;
    if (&slot.source->owner() != &calculation.owner()) {
      Fault(fmt::format("'{}' uses '{}', which belongs to another block: declare an input and connect it",
                        calculation.path(), slot.source->path()));
    }
    if (calculation.kind() == SourceKind::kNextJump && slot.source->kind() != SourceKind::kParameter &&
        slot.source->kind() != SourceKind::kDiscrete) {
      Fault(fmt::format("'{}' uses '{}': a NextJump may use `time`, Parameters and discrete states",
                        calculation.path(), slot.source->name()));
    }
    if (slot.source->kind() == SourceKind::kRandom && !calculation.is_sampled() &&
        calculation.kind() != SourceKind::kUpdate) {
      Fault(
          fmt::format("'{}' uses the random stream '{}' but is not a sampled output or update: the "
                      "integrator may evaluate it any number of times; declare it Sampled",
                      calculation.path(), slot.source->name()));
    }
  }
}

}  // namespace tenon::internal
