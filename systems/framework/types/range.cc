#include <tenon/systems/framework/types/range.h>
#include <tenon/systems/framework/types/signal.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>

#include <algorithm>

namespace tenon {

Range& Range::Finite() {
  any_ = false;
  return *this;
}

Range& Range::Above(double end) {
  low_ = end;
  low_open_ = true;
  return Finite();
}

Range& Range::AtLeast(double end) {
  low_ = end;
  low_open_ = false;
  return Finite();
}

Range& Range::Below(double end) {
  high_ = end;
  high_open_ = true;
  return Finite();
}

Range& Range::AtMost(double end) {
  high_ = end;
  high_open_ = false;
  return Finite();
}

Range& Range::OrInfinite() {
  if (std::isinf(low_)) low_open_ = false;
  if (std::isinf(high_)) high_open_ = false;
  return Finite();
}

Range& Range::Also(void (*check)(double value)) {
  check_ = check;
  return Finite();
}

Range& Range::Because(const char* remedy) {
  remedy_ = remedy;
  return *this;
}

bool Range::Contains(double value) const {
  if (any_) return true;
  if (!(low_open_ ? value > low_ : value >= low_) || !(high_open_ ? value < high_ : value <= high_))
    return false;
  try {
    if (check_ != nullptr) check_(value);
    return true;
  } catch (const ParameterError&) {
    return false;
  }
}

std::string Range::Text(const std::string& unit) const {
  const bool below = std::isinf(low_), above = std::isinf(high_);
  if (below && above) return "";
  const std::string suffix = unit.empty() ? "" : " " + unit;
  if (!below && !above && !low_open_ && !high_open_)
    return fmt::format("from {:.6g} to {:.6g}{}", low_, high_, suffix);
  std::string text;
  if (!below) text = fmt::format("{} {:.6g}", low_open_ ? "above" : "at least", low_);
  if (!above)
    text += fmt::format("{}{} {:.6g}", below ? "" : " and ", high_open_ ? "below" : "at most", high_);
  return text + suffix + ((above && !high_open_) || (below && !low_open_) ? ", or infinite" : "");
}

void Range::Refuse(double value, const std::string& name, const std::string& unit) const {
  Range interval = *this;
  interval.check_ = nullptr;
  if (check_ != nullptr && interval.Contains(value)) {
    try {
      check_(value);
    } catch (const ParameterError& error) {
      throw ParameterError(fmt::format("{}: {}", name, error.what()));
    }
  }
  const std::string text = Text(unit);
  throw ParameterError(fmt::format("{} = {:.10g} must be {}{}{}", name, value,
                                   !text.empty()             ? text
                                   : low_open_ && high_open_ ? "finite"
                                                             : "a number",
                                   *remedy_ == '\0' ? "" : ": ", remedy_));
}

namespace internal {
namespace {

/// Visits numbers together with the range, the unit and the path of each.
class RangeVisitor : public ValueVisitor {
 public:
  RangeVisitor(const Ranged& root, std::string prefix) : prefix_(std::move(prefix)) {
    path_.push_back({root, 0, false});
  }

  void EnterMember(const Field& field) final {
    path_.push_back({{field.name, field.units, &field.range, &field.type()}, 0, false});
  }
  void EnterItem(std::size_t index) final {
    Part item = path_.back();
    item.member.type = &item.member.type->item();
    item.index = index;
    item.is_item = true;
    path_.push_back(item);
  }
  void Leave() final { path_.pop_back(); }
  void Number(void* data, const TypeInfo& type) final { Visit(data, type.scalar, 1, 0); }
  void Numbers(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) final {
    Visit(data, kind, rows, cols);
  }

 protected:
  ~RangeVisitor() = default;
  /// `cols` is 0 for a number that is no matrix.
  virtual void Visit(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) = 0;
  const Ranged& member() const { return path_.back().member; }

  std::string Path() const {
    std::string path = prefix_;
    for (std::size_t i = 0; i < path_.size(); ++i) {
      const bool is_item = path_[i].is_item;
      if (is_item && path_[i - 1].member.type->kind == TypeInfo::Kind::kOptional) continue;
      if (!path.empty()) path += '.';
      path += is_item ? std::to_string(path_[i].index) : path_[i].member.name;
    }
    return path;
  }

 private:
  struct Part {
    Ranged member;
    std::size_t index;  ///< of an item of the member
    bool is_item;
  };
  std::string prefix_;
  std::vector<Part> path_;
};

class Checker final : public RangeVisitor {
 public:
  using RangeVisitor::RangeVisitor;

 private:
  void Visit(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    if (member().range->any()) return;
    WithKind(kind, data, [&](const auto* numbers) {
      for (std::size_t i = 0; i < rows * std::max<std::size_t>(cols, 1); ++i)
        if (const auto value = static_cast<double>(numbers[i]); !member().range->Contains(value))
          Refuse(value, i, rows, cols);
    });
  }

  [[noreturn]] void Refuse(double value, std::size_t i, std::size_t rows, std::size_t cols) const {
    std::string path = Path();
    if (cols > 0) path += "." + std::to_string(i % rows);
    if (cols > 1) path += "." + std::to_string(i / rows);
    const std::string unit = *member().units == '\0' ? UnitOfKey(member().name)
                                                     : ElementUnit(Spec(member().name, member().units), i);
    member().range->Refuse(value, path, unit);
  }
};

class Lister final : public RangeVisitor {
 public:
  using RangeVisitor::RangeVisitor;
  std::vector<Range> ranges;

 private:
  void Visit(void*, ScalarKind, std::size_t rows, std::size_t cols) override {
    ranges.insert(ranges.end(), rows * std::max<std::size_t>(cols, 1), *member().range);
  }
};

}  // namespace

void CheckRange(const Ranged& member, const void* value, const char* path) {
  Checker checker(member, path);
  Walk(*member.type, const_cast<void*>(value), checker);
}

void CheckRange(const Field& field, const void* object, const char* path) {
  CheckRange({field.name, field.units, &field.range, &field.type()},
             static_cast<const std::byte*>(object) + field.offset, path);
}

void CheckRanges(const FieldList& fields, const void* object, const char* path) {
  for (const Field& field : fields)
    if (field.type != nullptr) CheckRange(field, object, path);
}

std::vector<Range> ListRanges(const Ranged& member, const void* value) {
  Lister lister(member, "");
  Walk(*member.type, const_cast<void*>(value), lister);
  return std::move(lister.ranges);
}

}  // namespace internal
}  // namespace tenon
