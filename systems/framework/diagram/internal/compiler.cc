#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/diagram/internal/compiler.h>

#include <fmt/core.h>

namespace tenon::internal {
namespace {

constexpr int kUnvisited = -1;
constexpr int kOnTrail = -2;

bool GivesValue(const Source& source) {
  return source.kind() == SourceKind::kOutput || source.kind() == SourceKind::kShared;
}

/// True for sources that run at their ticks in dataflow order.
bool IsDueInOrder(const Source& source) {
  return source.is_sampled() && (GivesValue(source) || source.kind() == SourceKind::kPublish);
}

/// Appends the result of System::path() without intermediate strings.
void AppendPath(const System& block, std::string& path) {
  if (block.parent() != nullptr) {
    AppendPath(*block.parent(), path);
    if (!path.empty()) path += '.';
  }
  path += block.name();
}

}  // namespace

Program Compiler::Compile(const std::vector<std::unique_ptr<System>>& blocks, bool open_inputs) {
  return std::move(Compiler(blocks, open_inputs).program_);
}

Compiler::Compiler(const std::vector<std::unique_ptr<System>>& blocks, bool open_inputs)
    : open_inputs_(open_inputs) {
  Collect(blocks);
  for (const System* block : replacements_) CheckReplacement(*block);
  ResolveInputs();
  CheckDeclarations();
  CheckConnections();
  ThrowFaults();
  MergeShared();
  DeclareSizes();
  Order();
  LayOut();
  FillArguments();
  FindFeeders();
  FindGroups();
  MakePlans();
}

void Compiler::Collect(const std::vector<std::unique_ptr<System>>& blocks) {
  for (const auto& block : blocks) {
    CheckMembers(*block);
    if (block->replaces_ != nullptr) replacements_.push_back(block.get());
    if (auto* subdiagram = dynamic_cast<Subdiagram*>(block.get())) {
      ports_.insert(ports_.end(), block->sources().begin(), block->sources().end());
      Collect(subdiagram->blocks_);
    } else {
      sources_.insert(sources_.end(), block->sources().begin(), block->sources().end());
    }
  }
}

/// Lets shared values of different blocks that are the same function of the same values be computed once: the
/// first one drives the others.
void Compiler::MergeShared() {
  const auto same_argument = [](const Slot& a, const Slot& b) {
    if (a.source == nullptr || b.source == nullptr)
      return a.what == b.what && a.source == b.source && a.count == b.count;
    return &a.source->Resolve() == &b.source->Resolve();
  };
  std::unordered_map<Thunk, std::vector<Source*>> found;
  for (Source* source : sources_) {
    if (source->equal_ == nullptr) continue;
    std::vector<Source*>& others = found[source->run_];
    const auto other = std::find_if(others.begin(), others.end(), [&](const Source* before) {
      return before->equal_ == source->equal_ && before->equal_(*before->closure_, *source->closure_) &&
             std::ranges::equal(before->arguments_, source->arguments_, same_argument);
    });
    if (other == others.end()) {
      others.push_back(source);
    } else {
      source->SetDriver(**other);
      source->run_ = nullptr;
    }
  }
}

/// Tells each calculation of a matrix of run-time size the size that it, or a port that reads it, declares.
void Compiler::DeclareSizes() {
  const auto has_run_time_size = [](const Source& source) {
    return source.type_->kind == TypeInfo::Kind::kMatrix && source.type_->shape != nullptr &&
           source.kind() != SourceKind::kScratch && source.kind() != SourceKind::kWorkspace;
  };
  for (const auto* list : {&sources_, &ports_}) {
    for (Source* source : *list) {
      if (!has_run_time_size(*source)) continue;
      auto& origin = const_cast<Source&>(source->Resolve());
      for (const Source* each : {static_cast<const Source*>(&origin), static_cast<const Source*>(source)}) {
        if (origin.declares_size_ == nullptr && CountScalars(*each->type_, each->model_) > 0)
          origin.declares_size_ = each;
      }
    }
  }
  for (Source* source : sources_) {
    // The derivatives' sizes are checked when they are copied.
    if (source->run_ == nullptr || !has_run_time_size(*source) || source->kind() == SourceKind::kDerivative)
      continue;
    const Source& result = source->kind() == SourceKind::kUpdate ? *source->target_ : *source;
    source->declares_size_ = result.declares_size_;
    if (source->declares_size_ == nullptr) continue;
    const Extents shape = ExtentsOf(*source->type_, source->declares_size_->model_);
    source->closure_->rows = static_cast<std::int32_t>(shape.rows);
    source->closure_->cols = static_cast<std::int32_t>(shape.cols);
  }
}

/// Numbers the calculations in dataflow order: first those that compute values, then the others.
void Compiler::Order() {
  std::vector<const Source*> trail;
  for (Source* source : sources_) source->calculation_ = kUnvisited;
  program_.calculations.reserve(sources_.size());
  OrderPublishes();
  for (Source* source : sources_) {
    if (source->run_ != nullptr && GivesValue(*source)) Visit(*source, trail);
  }
  for (Source* source : sources_) {
    if (source->calculation_ == kUnvisited && source->run_ != nullptr) AddCalculation(*source);
  }
  for (std::size_t i = 0; i < program_.calculations.size(); ++i) {
    for (const int used : program_.calculations[i].uses)
      program_.calculations[used].affects.push_back(static_cast<int>(i));
  }
}

/// Orders Publishes before ExternalPorts of the same tick that they do not depend on, because the external
/// answer may depend on what was sent.
void Compiler::OrderPublishes() {
  std::vector<std::pair<std::size_t, Source*>> publishes;  // by number of external inputs used
  for (Source* source : sources_) {
    if (source->kind() != SourceKind::kPublish || !source->is_sampled()) continue;
    std::unordered_set<const Source*> seen;
    std::vector<const Source*> open{source};
    std::size_t depends = 0;
    while (!open.empty()) {
      const Source& next = *open.back();
      open.pop_back();
      for (const Slot& slot : next.arguments_) {
        if (slot.source == nullptr) continue;
        const Source& origin = slot.source->Resolve();
        if (origin.run_ == nullptr || !seen.insert(&origin).second) continue;
        if (origin.comes_from_outside_) ++depends;
        open.push_back(&origin);
      }
    }
    publishes.emplace_back(depends, source);
  }
  std::ranges::stable_sort(publishes, {}, &std::pair<std::size_t, Source*>::first);
  std::vector<const Source*> trail;
  for (const auto& [depends, source] : publishes) Visit(*source, trail);
}

void Compiler::Visit(Source& source, std::vector<const Source*>& trail) {
  if (source.calculation_ >= 0) return;
  trail.push_back(&source);
  source.calculation_ = kOnTrail;
  for (const Slot& slot : source.arguments_) {
    if (slot.source == nullptr) continue;
    auto& origin = const_cast<Source&>(slot.source->Resolve());
    if (origin.run_ == nullptr) continue;
    if (origin.calculation_ == kOnTrail) ThrowLoop(trail, origin);
    Visit(origin, trail);
  }
  trail.pop_back();
  AddCalculation(source);
}

void Compiler::AddCalculation(Source& source) {
  CalculationInfo info{&source, {}, {}, false, IsDueInOrder(source)};
  for (const Slot& slot : source.arguments_) {
    if (slot.what == Slot::What::kTime) info.varies = true;
    if (slot.source == nullptr) {
      info.settled = false;
      continue;
    }
    const Source& origin = slot.source->Resolve();
    if (origin.kind() == SourceKind::kContinuous) info.varies = true;
    info.settled &= origin.run_ != nullptr ? program_.calculations[origin.calculation_].settled
                                           : origin.kind() == SourceKind::kParameter;
    if (origin.run_ == nullptr) continue;
    info.uses.push_back(origin.calculation_);
    info.varies |= program_.calculations[origin.calculation_].varies;
  }
  if (info.sampled) info.varies = info.settled = false;
  source.calculation_ = static_cast<int>(program_.calculations.size());
  for (const Slot& slot : source.arguments_) {
    if (slot.source == nullptr || info.sampled) continue;
    const Source& origin = slot.source->Resolve();
    if (origin.kind() == SourceKind::kDiscrete) program_.readers[&origin].push_back(source.calculation_);
  }
  program_.calculations.push_back(std::move(info));
}

void Compiler::ThrowLoop(const std::vector<const Source*>& trail, const Source& again) const {
  std::string hops;
  bool in_loop = false, sampled = false;
  for (const Source* source : trail) {
    in_loop |= source == &again;
    if (!in_loop) continue;
    sampled |= source->is_sampled();
    hops += fmt::format("'{}' uses ", source->path());
  }
  throw BuildError(fmt::format(
      "algebraic loop: {}'{}'. Every hop needs the value of the next at the same instant. Break the loop {}",
      hops, again.path(),
      sampled ? "with a UnitDelay in front of one of the sampled inputs."
              : "with a block that has state (a filter, a UnitDelay), or sample one of these outputs behind "
                "a UnitDelay."));
}

void Compiler::Place(Source& source, std::size_t& end) {
  end = AlignUp(end, source.type_->alignment);
  source.offset_ = static_cast<Offset>(end);
  program_.cells.push_back({&source, source.offset_});
  if (!source.type_->bitwise) program_.objects.push_back(program_.cells.back());
  end += source.type_->size;
}

void Compiler::LayOut() {
  std::size_t end = sizeof(double);  // time
  program_.continuous_begin = static_cast<Offset>(end);
  for (Source* source : sources_) {
    if (source->kind() != SourceKind::kContinuous) continue;
    program_.continuous.push_back(source);
    if (source->type_->fixed) {
      Place(*source, end);
      continue;
    }
    const std::size_t count = CountScalars(*source->type_, source->model_);
    program_.unpacked_states.push_back({source, static_cast<Offset>(end), count});
    end += count * sizeof(double);
  }
  const std::size_t continuous_size = end - program_.continuous_begin;
  program_.num_continuous = static_cast<int>(continuous_size / sizeof(double));
  program_.derivative_begin = static_cast<Offset>(end);
  end += continuous_size;
  for (Source* source : sources_) {
    if (source->kind() != SourceKind::kDerivative) continue;
    if (source->type_->fixed) {
      source->offset_ = static_cast<Offset>(source->target_->offset_ + continuous_size);
      continue;
    }
    for (const Unpacked& state : program_.unpacked_states) {
      if (state.source != source->target_) continue;
      program_.unpacked_derivatives.push_back(
          {source, static_cast<Offset>(state.offset + continuous_size), state.count});
    }
  }
  // A value whose copy is a derivative shares the memory of that derivative, which saves the copy. Held
  // samples keep their own memory, because the first copy happens after the first sample.
  std::unordered_set<const Source*> shared;
  for (const Source* source : sources_) {
    if (!source->is_copy_ || !source->type_->fixed) continue;
    auto& origin = const_cast<Source&>(source->arguments_[0].source->Resolve());
    if (origin.run_ == nullptr || origin.is_sampled() || !shared.insert(&origin).second) continue;
    origin.offset_ = source->offset_;
    program_.cells.push_back({&origin, origin.offset_});
  }
  // All other stored values; those that are copied as bytes come first. Parameters and Publishes come last,
  // so that adding one to a block does not move other values: the last digits of Eigen's results depend on
  // alignment.
  std::vector<Source*> stored, last;
  for (Source* source : sources_) {
    const bool passes_on =
        source->kind() == SourceKind::kInput || (GivesValue(*source) && source->run_ == nullptr);
    const bool integrated =
        source->kind() == SourceKind::kContinuous || source->kind() == SourceKind::kDerivative;
    if ((integrated && source->type_->fixed) || passes_on || shared.contains(source)) continue;
    const bool added = source->kind() == SourceKind::kParameter || source->kind() == SourceKind::kPublish ||
                       source->kind() == SourceKind::kKink || source->kind() == SourceKind::kNextJump;
    (added ? last : stored).push_back(source);
  }
  for (const Source* input : default_inputs_) stored.push_back(const_cast<Source*>(input));
  for (const Source* input : program_.open_inputs) stored.push_back(const_cast<Source*>(input));
  for (const bool bitwise : {true, false}) {
    for (Source* source : stored) {
      if (source->type_->bitwise != bitwise) continue;
      Place(*source, end);
    }
  }
  for (Source* source : last) Place(*source, end);
  program_.memory_size = end;
  if (end > UINT32_MAX) throw BuildError("the diagram's signals take more than 4 GiB: split the diagram");

  // Ports that only pass a value on share the memory of its origin.
  for (const auto* list : {&sources_, &ports_}) {
    for (Source* source : *list) {
      const Source& origin = source->Resolve();
      source->offset_ = origin.offset_;
      source->calculation_ = origin.calculation_;
    }
  }
  Fnv1a checksum;
  std::string line;
  for (const Cell& cell : program_.cells) {
    const Source& source = *cell.source;
    line.clear();
    AppendPath(source.owner(), line);
    line += '.';
    line += source.name();
    for (const std::size_t number : {std::size_t{cell.offset}, source.type_->size}) {
      line += ' ';
      line += std::to_string(number);
    }
    line += '\n';
    checksum.Add(line);
    const bool held = source.kind() == SourceKind::kOutput && source.is_sampled();
    const bool kept = source.kind() == SourceKind::kContinuous || source.kind() == SourceKind::kDiscrete ||
                      source.kind() == SourceKind::kInput || source.kind() == SourceKind::kScratch ||
                      source.kind() == SourceKind::kRandom || source.kind() == SourceKind::kParameter;
    // Warm-started calculations would give another result if computed again after Restore.
    const bool warm = GivesValue(source) &&
                      std::any_of(source.arguments_.begin(), source.arguments_.end(), [](const Slot& slot) {
                        return slot.source != nullptr && slot.source->kind() == SourceKind::kScratch;
                      });
    if (held || kept || warm) program_.saved.push_back(cell);
  }
  program_.signature = checksum.value();
}

void Compiler::FillArguments() {
  std::vector<std::size_t> begins;
  begins.reserve(program_.calculations.size());
  for (const CalculationInfo& info : program_.calculations) {
    begins.push_back(program_.rows.size());
    Program::AppendRows({&info.source, 1}, program_.rows);
  }
  for (std::size_t i = 0; i < begins.size(); ++i) {
    CalculationInfo& info = program_.calculations[i];
    info.op = {info.source->run_,
               info.source->closure_.get(),
               program_.rows.data() + begins[i],
               static_cast<std::uint32_t>(i),
               info.varies,
               false};
  }
}

}  // namespace tenon::internal
