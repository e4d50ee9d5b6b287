#include <tenon/systems/framework/system.h>

#include <fmt/core.h>

#include <tenon/systems/framework/calculation.h>

namespace tenon {

std::string System::path() const {
  return parent_ == nullptr ? name_ : parent_->path() + "." + name_;
}

Source::Source(System* owner, SourceKind kind, Spec spec, const internal::TypeInfo& type, const void* model)
    : owner_(owner), kind_(kind), spec_(std::move(spec)), type_(&type), model_(model) {
  owner_->sources_.push_back(this);
}

std::string Source::path() const {
  return owner_->path() + "." + spec_.name;
}

std::vector<Element> Source::elements() const {
  std::vector<Element> elements;
  type_->list_elements(model_, spec_, elements);
  return elements;
}

const Source& Source::Resolve() const {
  const Source* source = this;
  while (source->driver_ != nullptr) source = source->driver_;
  return *source;
}

void Source::SetCalculation(internal::Thunk run, std::shared_ptr<const void> closure,
                            std::vector<Slot> arguments) {
  run_ = run;
  closure_ = std::move(closure);
  arguments_ = std::move(arguments);
}

internal::Offset Reads::Find(const Source& source) const {
  for (std::size_t i = 0; i < declared_.size(); ++i) {
    if (declared_[i] == &source) return offsets_[i];
  }
  std::string names;
  for (const Source* declared : declared_) names += (names.empty() ? "" : ", ") + declared->name();
  throw RunError(fmt::format(
      "undeclared dependency: a calculation reads '{}' but declared only [{}]; add it to UsesAtRunTime",
      source.path(), names));
}

}  // namespace tenon
