#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/diagram/internal/compiler.h>

#include <fmt/core.h>

#include <exception>

namespace tenon {

namespace {

/// Returns the member of a block that has the kind, name and type of `source`, or null.
Source* Counterpart(const System& block, const Source& source) {
  for (Source* own : block.sources()) {
    if (own->kind() == source.kind() && own->name() == source.name() && *own->type().id == *source.type().id)
      return own;
  }
  return nullptr;
}

}  // namespace

namespace internal {

void Assembly::CheckNotBuilt(const char* call, const std::string& subject) const {
  if (!built_) return;
  throw BuildError(fmt::format(
      "{}({}): {} already built and cannot change: call it before Build, or use another builder", call,
      subject.empty() ? "" : "'" + subject + "'",
      self_ == nullptr ? "this builder has" : fmt::format("the diagram with '{}' is", self_->path())));
}

void Assembly::MarkBuilt(bool replaced) {
  built_ = true;
  for (const auto* blocks : {&blocks_, &replaced_}) {
    const bool gone = replaced || blocks == &replaced_;
    for (const auto& block : *blocks) {
      if (self_ == nullptr) block->holder_ = nullptr;  // another builder may be created at this address
      for (Source* source : block->sources_) {
        const Source* now = gone ? FindCurrent(*source) : nullptr;
        if (now == nullptr) continue;
        source->SetDriver(*now);
        source->offset_ = now->offset_;
        source->calculation_ = now->calculation_;
      }
      if (auto* nested = dynamic_cast<Subdiagram*>(block.get())) nested->MarkBuilt(gone);
    }
  }
}

void Assembly::CheckName(const std::string& name) const {
  CheckNotBuilt("Add", name);
  const bool fits =
      std::ranges::all_of(name, [](unsigned char c) { return c > ' ' && c != 0x7F && c != '.' && c != ','; });
  if (name.empty() || !fits) {
    throw BuildError(
        fmt::format("a block cannot be named '{}': give a name without dots, commas, blanks and control "
                    "characters",
                    name));
  }
  if (by_name_.contains(name)) {
    throw BuildError(fmt::format("there are two blocks named '{}': give one of them another name", name));
  }
}

System& Assembly::Adopt(std::unique_ptr<System> block, const std::string& name) {
  block->name_ = name;
  block->parent_ = self_;
  block->holder_ = this;
  by_name_.emplace(name, block.get());
  blocks_.push_back(std::move(block));
  return *blocks_.back();
}

void Assembly::RethrowWithName(const std::string& name) {
  const auto path = [&](const Error& error) {
    return error.block().empty() ? name : name + "." + error.block();
  };
  try {
    throw;
  } catch (const ParameterError& error) {
    std::throw_with_nested(ParameterError(fmt::format("block '{}': {}", name, error.what()), path(error)));
  } catch (const BuildError& error) {
    std::throw_with_nested(BuildError(fmt::format("inside '{}': {}", name, error.what()), path(error)));
  }
}

bool Assembly::IsBelow(const System& block) const {
  for (const System* each = &block; each != nullptr; each = each->parent_) {
    if (each->holder_ == this) return true;
  }
  return false;
}

void Assembly::CheckBelow(const System& block) const {
  CheckNotBuilt("Replace", block.path());
  if (!IsBelow(block)) {
    throw BuildError(fmt::format(
        "block '{}' cannot be replaced here: it was not added to this builder or nested diagram, or is "
        "already built; replace blocks before Build",
        block.path()));
  }
}

/// Returns the port in the place of `port`. Throws BuildError unless it can be connected here.
Source& Assembly::Standing(const Source& port) const {
  const Source& now = port.Current();
  if (&now.owner() != self_ && !IsBelow(now.owner())) {
    throw BuildError(fmt::format(
        "port '{}' does not belong to a block of this builder: change connections before Build, through the "
        "builder that contains both blocks",
        port.path()));
  }
  return const_cast<Source&>(now);  // a port of a block that this builder owns
}

void Assembly::AppendSources(std::vector<Source*>& sources) {
  if (self_ != nullptr) sources.insert(sources.end(), self_->sources_.begin(), self_->sources_.end());
  for (const auto& block : blocks_) {
    if (auto* nested = dynamic_cast<Subdiagram*>(block.get())) {
      nested->AppendSources(sources);
    } else {
      sources.insert(sources.end(), block->sources_.begin(), block->sources_.end());
    }
  }
}

std::vector<Source*> Assembly::AllSources() {
  Assembly* root = this;
  while (root->self_ != nullptr && root->self_->holder_ != nullptr) root = root->self_->holder_;
  std::vector<Source*> sources;
  root->AppendSources(sources);
  return sources;
}

System& Assembly::Exchange(const System& former, std::unique_ptr<System> made) {
  const System* const stands = CurrentBlock(former);
  if (stands == nullptr)
    throw BuildError(fmt::format(
        "block '{}' cannot be replaced: a diagram around it was replaced by one that has no block "
        "of this name; replace a block of the new one",
        former.path()));
  const System& old = *stands;
  std::vector<std::unique_ptr<System>>& siblings = old.holder_->blocks_;
  const auto place =
      std::find_if(siblings.begin(), siblings.end(), [&](const auto& block) { return block.get() == &old; });
  std::swap(*place, made);
  System &block = **place, &replaced = *made;
  block.name_ = replaced.name_;
  block.parent_ = replaced.parent_;
  block.holder_ = replaced.holder_;
  block.replaces_ = &replaced;
  replaced.replaced_by_ = &block;
  old.holder_->by_name_[block.name_] = &block;
  old.holder_->replaced_.push_back(std::move(made));

  // Include the names of blocks that were replaced earlier, and their readers without a connection.
  for (const System* before = &replaced; before != nullptr; before = before->replaces_) {
    for (const Source* port : before->sources_) {
      if (port->kind() != SourceKind::kInput || port->driver_ == nullptr) continue;
      Source* input = Counterpart(block, *port);
      if (input == nullptr || input->driver_ != nullptr) continue;
      input->SetDriver(*port->driver_);
      input->ignores_units_ = port->ignores_units_;
    }
  }
  const auto replaces = [&](const System* driver) {
    while (driver != &block && driver->replaced_by_ != nullptr) driver = driver->replaced_by_;
    return driver == &block;
  };
  for (Source* source : AllSources()) {
    if (source->driver_ == nullptr || source->driver_->kind() != SourceKind::kOutput ||
        &source->driver_->owner() == &block || !replaces(&source->driver_->owner())) {
      continue;
    }
    if (const Source* output = Counterpart(block, *source->driver_)) source->SetDriver(*output);
  }
  return block;
}

void Assembly::Splice(const Source& former_output, Source& former_in, const Source& former_out,
                      const std::vector<const Source*>& except) {
  CheckNotBuilt("Insert", former_in.path());
  const Source &output = Standing(former_output), &out = Standing(former_out);
  Source& in = Standing(former_in);
  if (in.kind() != SourceKind::kInput || out.kind() != SourceKind::kOutput) {
    throw BuildError(
        fmt::format("cannot insert from '{}' to '{}': give an input and an output of a block, in this order",
                    in.path(), out.path()));
  }
  if (in.driver_ != nullptr && in.driver_ != &output) {
    throw BuildError(fmt::format("'{}' cannot be inserted behind '{}': it is already connected to '{}'",
                                 in.path(), output.path(), in.driver_->path()));
  }
  const auto excepted = [&](const Source* reader) {
    return std::ranges::any_of(except, [&](const Source* each) { return FindCurrent(*each) == reader; });
  };
  bool read = false;
  for (Source* source : AllSources()) {
    if (source->driver_ != &output || source == &in || excepted(source)) continue;
    source->SetDriver(out);
    read = true;
  }
  if (!read) {
    throw BuildError(
        fmt::format("'{}' has no readers, so '{}' cannot be inserted there: give a port that is connected",
                    output.path(), in.owner().path()));
  }
  in.SetDriver(output);
}

void Assembly::SpliceBefore(Source& former, Source& in, const Source& out) {
  CheckNotBuilt("InsertBefore", former.path());
  Source& input = Standing(former);
  const Source* const driver = input.driver_;
  input.driver_ = nullptr;
  Join(out, input);
  if (driver != nullptr) Join(*driver, in);
}

void Assembly::Disconnect(Source& former) {
  CheckNotBuilt("Disconnect", former.path());
  Source& input = Standing(former);
  const bool port =
      input.kind() == SourceKind::kInput || (input.kind() == SourceKind::kOutput && input.run_ == nullptr &&
                                             dynamic_cast<const Subdiagram*>(&input.owner()) != nullptr);
  if (!port || input.driver_ == nullptr) {
    throw BuildError(fmt::format("'{}' has no connection to remove", input.path()));
  }
  input.driver_ = nullptr;
  input.ignores_units_ = false;
}

void Assembly::Join(const Source& former_from, Source& former_to) {
  CheckNotBuilt("Connect", former_to.path());
  const Source& from = former_from.Current();
  Source& to = const_cast<Source&>(former_to.Current());
  const auto is_here = [&](const Source& port, SourceKind child, SourceKind own) {
    const System& owner = port.owner();
    if (&owner == self_ && self_ != nullptr) return port.kind() == own;
    if (owner.holder_ == this) return port.kind() == child;
    if (self_ != nullptr || !IsBelow(owner)) return false;
    return port.kind() == child || (port.kind() == own && dynamic_cast<const Subdiagram*>(&owner) != nullptr);
  };
  const auto check = [&](const Source& port, SourceKind child, SourceKind own, const char* role) {
    if (is_here(port, child, own)) return;
    throw BuildError(fmt::format(
        "port '{}' cannot be the {} of a connection here: it belongs to a block of another builder or nested "
        "diagram, or has the wrong direction; connect outputs of blocks of this builder to their inputs",
        port.path(), role));
  };
  check(from, SourceKind::kOutput, SourceKind::kInput, "source");
  check(to, SourceKind::kInput, SourceKind::kOutput, "target");
  if (to.driver_ != nullptr) {
    throw BuildError(fmt::format("port '{}' is connected twice: to '{}' and to '{}'; remove one connection",
                                 to.path(), to.driver_->path(), from.path()));
  }
  to.SetDriver(from);
}

void Assembly::IgnoreUnitsOf(Source& to) {
  const_cast<Source&>(to.Current()).ignores_units_ = true;
}

}  // namespace internal

const System* CurrentBlock(const System& block) {
  const System* replaced = nullptr;  // the outermost replaced block
  for (const System* each = &block; each != nullptr; each = each->parent())
    if (each->replaced_by() != nullptr) replaced = each;
  if (replaced == nullptr) return &block;
  std::vector<std::string> names;  // names from the inside out
  for (const System* each = &block; each != replaced; each = each->parent()) names.push_back(each->name());
  const System* now = replaced;
  while (now->replaced_by() != nullptr) now = now->replaced_by();
  for (; now != nullptr && !names.empty(); names.pop_back()) {
    const auto* nested = dynamic_cast<const Subdiagram*>(now);
    now = nullptr;
    if (nested == nullptr) break;
    for (const auto& each : nested->blocks())
      if (each->name() == names.back()) now = each.get();
  }
  return now;
}

const Source* FindCurrent(const Source& source) {
  const System* const block = CurrentBlock(source.owner());
  if (block == &source.owner()) return &source;
  return block == nullptr ? nullptr : Counterpart(*block, source);
}

const Source& Source::Current() const {
  if (const Source* const now = FindCurrent(*this)) return *now;
  throw BuildError(fmt::format(
      "'{}' is needed, but the block that replaced '{}' has no '{}' ({}): add it to that block, or remove "
      "its readers",
      path(), owner_->path(), name(), type_name()));
}

std::shared_ptr<const Diagram> DiagramBuilder::Compile(const char* call, bool open_inputs) {
  CheckNotBuilt(call, "");
  auto program =
      std::make_unique<const internal::Program>(internal::Compiler::Compile(blocks(), open_inputs));
  MarkBuilt();
  return std::shared_ptr<const Diagram>(new Diagram(TakeBlocks(), TakeReplaced(), std::move(program)));
}

std::shared_ptr<const Diagram> DiagramBuilder::Build() {
  return Compile("Build", false);
}

std::shared_ptr<const Diagram> DiagramBuilder::BuildWithOpenInputs() {
  return Compile("BuildWithOpenInputs", true);
}

}  // namespace tenon
