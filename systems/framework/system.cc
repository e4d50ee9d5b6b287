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

std::string Source::type_name() const {
  return internal::TypeName(*type_);
}

std::vector<Element> Source::elements() const {
  return internal::ListElements(*type_, model_, spec_);
}

std::vector<double> Source::initial_numbers() const {
  std::vector<double> numbers(internal::CountScalars(*type_, model_));
  internal::ToDoubles(*type_, model_, numbers.data());
  return numbers;
}

std::vector<const Source*> Source::uses() const {
  std::vector<const Source*> sources;
  for (const internal::Slot& slot : arguments_) {
    if (slot.what == internal::Slot::What::kSource) sources.push_back(slot.source);
  }
  return sources;
}

const Source& Source::Resolve() const {
  const Source* source = this;
  while (source->driver_ != nullptr) source = source->driver_;
  return *source;
}

UsesList<Reads> UsesAtRunTime(const std::vector<const Source*>& sources) {
  UsesList<Reads> uses;
  uses.slots.push_back({internal::Slot::What::kList, nullptr, static_cast<std::uint32_t>(sources.size())});
  for (const Source* source : sources) source->AppendTo(uses.slots);
  return uses;
}

internal::Offset Reads::Find(const Source& source) const {
  // All that the calculation uses is this list: the first entry stands for it, the others are its sources.
  const std::vector<internal::Slot>& slots = calculation_.arguments_;
  std::string names;
  for (std::size_t i = 1; i < slots.size(); ++i) {
    if (slots[i].source == &source) return offsets_[i - 1];
    names += (names.empty() ? "" : ", ") + slots[i].source->name();
  }
  throw RunError(fmt::format(
      "undeclared dependency: a calculation reads '{}' but declared only [{}]; add it to UsesAtRunTime",
      source.path(), names));
}

}  // namespace tenon
