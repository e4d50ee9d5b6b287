#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/system.h>

#include <fmt/core.h>

#include <algorithm>
#include <mutex>
#include <unordered_set>

namespace tenon {

std::string System::path() const {
  // A diagram that is under construction has no name yet.
  const std::string above = parent_ == nullptr ? "" : parent_->path();
  return above.empty() ? name_ : above + "." + name_;
}

namespace internal {
namespace {

/// The existing members, by address. Blocks may be constructed in several threads.
struct Registry {
  std::mutex mutex;
  std::unordered_set<const Declared*> members;
};

/// Never destroyed: blocks may outlive static objects.
Registry& DeclaredMembers() {
  static auto* registry = new Registry;
  return *registry;
}

}  // namespace

Declared::Declared() {
  Registry& registry = DeclaredMembers();
  const std::lock_guard lock(registry.mutex);
  registry.members.insert(this);
}

Declared::~Declared() {
  Registry& registry = DeclaredMembers();
  const std::lock_guard lock(registry.mutex);
  registry.members.erase(this);
}

bool Declared::IsDeclared(const Declared& member) {
  Registry& registry = DeclaredMembers();
  const std::lock_guard lock(registry.mutex);
  return registry.members.contains(&member);
}

void ThrowUndeclared(const std::string& user, const std::string& used) {
  throw BuildError(fmt::format(
      "{} uses {}, which is declared below it and does not exist yet: move that declaration above it", user,
      used));
}

}  // namespace internal

void Source::CheckUses(int undeclared, bool merged) const {
  if (undeclared > 0) {
    internal::ThrowUndeclared(fmt::format("'{}'", name()),
                              fmt::format("member {} of its Uses(...)", undeclared));
  }
  if (merged) {
    throw BuildError(fmt::format(
        "this compiler confuses the function of '{}' with that of another member (Clang 14 does so with "
        "lambdas of a class declared inside a function): declare the block outside of functions, or use "
        "member functions",
        name()));
  }
}

Source::Source(System* owner, SourceKind kind, Spec spec, const internal::TypeInfo& type, const void* model)
    : owner_(owner), kind_(kind), spec_(std::move(spec)), type_(&type), model_(model) {
  if (owner_->sources_.empty()) owner_->sources_.reserve(8);
  owner_->sources_.push_back(this);
}

std::string Source::path() const {
  return owner_->path() + "." + spec_.name;
}

std::string Source::type_name() const {
  return internal::TypeName(*type_);
}

namespace internal {

/// The range of the member of `params` at an offset; every value if there is none.
static Range RangeAt(const FieldList* fields, std::size_t offset, const TypeInfo& type) {
  while (fields != nullptr) {
    const auto field = std::ranges::find_if(*fields, [&](const Field& each) {
      return each.type != nullptr && offset >= each.offset && offset < each.offset + each.size;
    });
    if (field == fields->end()) break;
    if (*field->type().id == *type.id) return field->range;
    offset -= field->offset;
    const TypeInfo* inner = &field->type();
    while (inner->kind == TypeInfo::Kind::kArray) {
      inner = &inner->item();
      offset %= inner->size;
      if (*inner->id == *type.id) return field->range;
    }
    fields = inner->kind == TypeInfo::Kind::kStruct ? &inner->fields : nullptr;
  }
  return {};
}

ParameterSource::ParameterSource(Leaf* owner, Spec spec, const TypeInfo& type, const void* model,
                                 const void* given, std::string description, const Range& range)
    : Source(owner, SourceKind::kParameter, std::move(spec), type, model),
      description_(std::move(description)),
      range_(range) {
  const std::span<const std::byte> params = owner->ParameterBytes();
  const auto begin = reinterpret_cast<std::uintptr_t>(params.data()),
             place = reinterpret_cast<std::uintptr_t>(given);
  if (place >= begin && place < begin + params.size()) {
    offset_in_params_ = place - begin;
    if (range_.any()) range_ = RangeAt(owner->ParameterFields(), offset_in_params_, type);
  }
  Check(given);
}

void ParameterSource::Check(const void* value) const {
  CheckRange({name().c_str(), spec().units.c_str(), &range_, &type()}, value);
  if (type().validate != nullptr) type().validate(value);
}

std::vector<Range> ParameterSource::ranges() const {
  return ListRanges({name().c_str(), spec().units.c_str(), &range_, &type()}, model());
}

}  // namespace internal

std::vector<Element> Source::elements() const {
  return internal::ListElements(*type_, model_, spec_);
}

std::vector<double> Source::initial_numbers() const {
  return internal::DoublesOf(*type_, model_);
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

void internal::ThrowOtherSize(const Closure& closure, std::ptrdiff_t rows, std::ptrdiff_t cols) {
  const Source* declares = closure.calculation->declares_size();
  throw RunError(
      fmt::format("its value has {} x {} elements, but '{}' is declared with {} x {}: make them equal", rows,
                  cols, declares->path(), closure.rows, closure.cols));
}

internal::Offset Reads::Find(const Source& source) const {
  // The calculation uses exactly this list: the first entry describes it, the others are its sources.
  const std::vector<internal::Slot>& slots = calculation_.arguments_;
  std::string names;
  for (std::size_t i = 1; i < slots.size(); ++i) {
    if (slots[i].source == &source) return offsets_[i - 1];
    names += (names.empty() ? "" : ", ") + slots[i].source->name();
  }
  throw RunError(fmt::format(
      "undeclared dependency: a calculation reads '{}', but declares only [{}]: add it to UsesAtRunTime",
      source.path(), names));
}

}  // namespace tenon
