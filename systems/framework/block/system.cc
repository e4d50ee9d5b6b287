#include <tenon/systems/framework/block/calculation.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/system.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

#include <cstdint>
#include <mutex>
#include <vector>

namespace tenon {

std::string System::path() const {
  // A diagram that is under construction has no name yet.
  const std::string above = parent_ == nullptr ? "" : parent_->path();
  return above.empty() ? name_ : above + "." + name_;
}

namespace internal {
namespace {

/// The members that exist, by their addresses: a table with open addressing, since a large diagram has tens
/// of thousands, and each is looked up when it is made, used and destroyed.
class Registry {
 public:
  void Insert(const Declared* member) {
    const std::lock_guard lock(mutex_);
    if (2 * ++count_ > table_.size()) Grow();
    Place(member);
  }
  void Erase(const Declared* member) {
    const std::lock_guard lock(mutex_);
    --count_;
    std::size_t hole = Find(member);
    // What stands behind and could not stand where it wanted to moves up.
    for (std::size_t i = Next(hole); table_[i] != nullptr; i = Next(i)) {
      const std::size_t wanted = Slot(table_[i]);
      const bool between = hole <= i ? wanted > hole && wanted <= i : wanted > hole || wanted <= i;
      if (between) continue;
      table_[hole] = table_[i];
      hole = i;
    }
    table_[hole] = nullptr;
  }
  bool Contains(const Declared* member) {
    const std::lock_guard lock(mutex_);
    return table_[Find(member)] == member;
  }

 private:
  std::size_t Slot(const Declared* member) const {
    const auto address = static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(member));
    return static_cast<std::size_t>((address * 0x9e3779b97f4a7c15u) >> 32) & (table_.size() - 1);
  }
  std::size_t Next(std::size_t i) const { return (i + 1) & (table_.size() - 1); }
  /// Where it is, or where it would be put.
  std::size_t Find(const Declared* member) const {
    std::size_t i = Slot(member);
    while (table_[i] != nullptr && table_[i] != member) i = Next(i);
    return i;
  }
  void Place(const Declared* member) { table_[Find(member)] = member; }
  void Grow() {
    std::vector<const Declared*> old(2 * table_.size(), nullptr);
    old.swap(table_);
    for (const Declared* member : old) {
      if (member != nullptr) Place(member);
    }
  }

  std::mutex mutex_;
  std::vector<const Declared*> table_ = std::vector<const Declared*>(1024, nullptr);  ///< a power of two
  std::size_t count_ = 0;
};

/// Never destroyed: blocks may outlive what is static.
Registry& DeclaredMembers() {
  static auto* registry = new Registry;
  return *registry;
}

}  // namespace

Declared::Declared() {
  DeclaredMembers().Insert(this);
}

Declared::~Declared() {
  DeclaredMembers().Erase(this);
}

bool Declared::IsDeclared(const Declared& member) {
  return DeclaredMembers().Contains(&member);
}

std::string DescribeReplacement(const Source& source) {
  for (const System* block = &source.owner(); block != nullptr; block = block->parent()) {
    if (block->replaced_by() == nullptr) continue;
    return fmt::format(
        "'{}' belongs to a block that was replaced: use the port of the new block at '{}', which Replace "
        "returned",
        source.path(), block->replaced_by()->path());
  }
  return "";
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
    throw BuildError(
        fmt::format("this compiler takes the function of '{}' for that of another member (Clang 14 does so "
                    "with lambdas of a "
                    "class declared inside a function): declare the block outside of functions, or give it "
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

ParameterSource::ParameterSource(Leaf* owner, Spec spec, const TypeInfo& type, const void* model,
                                 const void* given, std::string description)
    : Source(owner, SourceKind::kParameter, std::move(spec), type, model),
      description_(std::move(description)) {
  const std::span<const std::byte> params = owner->ParameterBytes();
  const auto begin = reinterpret_cast<std::uintptr_t>(params.data()),
             place = reinterpret_cast<std::uintptr_t>(given);
  if (place >= begin && place < begin + params.size()) offset_in_params_ = place - begin;
}

}  // namespace internal

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
