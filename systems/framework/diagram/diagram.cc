#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>

namespace tenon {

Diagram::Diagram(std::vector<std::unique_ptr<System>> blocks, std::vector<std::unique_ptr<System>> replaced,
                 std::unique_ptr<const internal::Program> program)
    : blocks_(std::move(blocks)), replaced_(std::move(replaced)), program_(std::move(program)) {}

Diagram::~Diagram() = default;

int Diagram::num_continuous_states() const {
  return program_->num_continuous;
}

bool Diagram::has_samples() const {
  return !program_->groups.empty();
}

std::vector<std::string> Diagram::ContinuousStateNames() const {
  std::vector<std::string> names;
  for (const Source* state : program_->continuous) {
    for (const Element& element : state->elements()) names.push_back(element.PathIn(state->path()));
  }
  return names;
}

const std::vector<const Source*>& Diagram::open_inputs() const {
  return program_->open_inputs;
}

void internal::ForEachBlock(const std::vector<std::unique_ptr<System>>& blocks,
                            const std::function<void(const System&)>& visit) {
  for (const auto& block : blocks) {
    visit(*block);
    if (const auto* nested = dynamic_cast<const Subdiagram*>(block.get()))
      ForEachBlock(nested->blocks(), visit);
  }
}

std::vector<const internal::ParameterSource*> Diagram::parameters() const {
  std::vector<const internal::ParameterSource*> found;
  internal::ForEachBlock(blocks_, [&](const System& block) {
    for (const Source* source : block.sources()) {
      if (source->kind() == SourceKind::kParameter)
        found.push_back(static_cast<const internal::ParameterSource*>(source));
    }
  });
  return found;
}

const System& Diagram::FindBlock(std::string_view path) const {
  const System* found = nullptr;
  std::vector<std::string> names;
  internal::ForEachBlock(blocks_, [&](const System& block) {
    names.push_back(block.path());
    if (names.back() == path) found = &block;
  });
  if (found == nullptr) {
    throw Error(fmt::format("there is no block '{}' in this diagram; did you mean '{}'?", path,
                            internal::NearestName(path, names)));
  }
  return *found;
}

const Source& Diagram::Find(std::string_view path) const {
  const Source* found = nullptr;
  std::vector<std::string> names;
  internal::ForEachBlock(blocks_, [&](const System& block) {
    for (const Source* source : block.sources()) {
      names.push_back(source->path());
      // A state and the output that shows it may have the same name: prefer the output.
      if (names.back() == path && (found == nullptr || source->kind() == SourceKind::kOutput)) found = source;
    }
  });
  if (found == nullptr) {
    throw Error(fmt::format("there is no signal '{}' in this diagram; did you mean '{}'?", path,
                            internal::NearestName(path, names)));
  }
  return *found;
}

}  // namespace tenon
