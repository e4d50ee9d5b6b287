#include <tenon/systems/framework/diagram_builder.h>

#include <fmt/core.h>

#include <exception>

#include <tenon/systems/framework/diagram.h>
#include <tenon/systems/framework/internal/compiler.h>

namespace tenon {

namespace internal {

void Assembly::CheckName(const std::string& name) const {
  if (name.empty() || name.find_first_of(". \t\n,") != std::string::npos) {
    throw BuildError(fmt::format(
        "a block cannot be named '{}': names are not empty and hold no dot, comma or blank", name));
  }
  if (by_name_.contains(name)) {
    throw BuildError(fmt::format("there are two blocks named '{}': give one of them another name", name));
  }
}

System& Assembly::Adopt(std::unique_ptr<System> block, const std::string& name) {
  block->name_ = name;
  block->parent_ = self_;
  by_name_.emplace(name, block.get());
  blocks_.push_back(std::move(block));
  return *blocks_.back();
}

void Assembly::RethrowWithName(const std::string& name) {
  try {
    throw;
  } catch (const ParameterError& error) {
    std::throw_with_nested(ParameterError(fmt::format("block '{}': {}", name, error.what())));
  } catch (const BuildError& error) {
    std::throw_with_nested(BuildError(fmt::format("inside '{}': {}", name, error.what())));
  }
}

void Assembly::Join(const Source& from, Source& to) {
  const auto is_here = [&](const Source& port, SourceKind child, SourceKind own) {
    const System& owner = port.owner();
    if (&owner == self_ && self_ != nullptr) return port.kind() == own;
    const auto namesake = by_name_.find(owner.name());
    return namesake != by_name_.end() && namesake->second == &owner && port.kind() == child;
  };
  const auto check = [&](const Source& port, SourceKind child, SourceKind own, const char* role) {
    if (is_here(port, child, own)) return;
    throw BuildError(fmt::format(
        "port '{}' cannot be the {} of a connection here: it belongs to a block of another builder or nested "
        "diagram, or points the wrong way; connect outputs of blocks of this builder to their inputs",
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
  to.ignores_units_ = true;
}

}  // namespace internal

std::shared_ptr<const Diagram> DiagramBuilder::Compile(bool open_inputs) {
  auto program =
      std::make_unique<const internal::Program>(internal::Compiler::Compile(blocks(), open_inputs));
  return std::shared_ptr<const Diagram>(new Diagram(TakeBlocks(), std::move(program)));
}

std::shared_ptr<const Diagram> DiagramBuilder::Build() {
  return Compile(false);
}

std::shared_ptr<const Diagram> DiagramBuilder::BuildWithOpenInputs() {
  return Compile(true);
}

}  // namespace tenon
