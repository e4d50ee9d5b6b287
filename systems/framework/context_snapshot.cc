#include <fmt/core.h>

#include <fstream>

#include <tenon/systems/framework/context.h>
#include <tenon/systems/framework/diagram.h>
#include <tenon/systems/framework/internal/program.h>

namespace tenon {

using internal::Cell;

std::vector<std::byte> Context::Save() const {
  const internal::Program& program = diagram_->program();
  if (!failure_.empty()) {
    throw RunError(fmt::format("a run that failed cannot be saved: {}; save before", failure_));
  }
  internal::Archive archive;
  internal::Save(program.signature, archive);
  internal::Save(time(), archive);
  internal::Save(seed_, archive);
  internal::Save(progress_, archive);
  internal::Save(next_step_, archive);
  internal::Save(last_error_, archive);
  internal::Save(step_start_.valid, archive);
  if (step_start_.valid) internal::Save(internal::TypeInfoOf<StepStart>(), &step_start_, archive);
  for (const Cell& cell : program.saved) {
    const Source& source = *cell.source;
    const bool fresh = source.calculation_ < 0 || IsFresh(program.calculations[source.calculation_].op);
    internal::Save(fresh, archive);
    try {
      internal::Save(*source.type_, memory_.get() + cell.offset, archive);
    } catch (const Error& error) {
      throw RunError(fmt::format("'{}' cannot be saved: {}", source.path(), error.what()));
    }
  }
  for (const bool fixed : fixed_) internal::Save(fixed, archive);
  return archive.bytes();
}

void Context::Restore(std::span<const std::byte> bytes) {
  Clone()->Load(bytes);  // a snapshot that is refused leaves this context as it is
  Load(bytes);
}

void Context::Load(std::span<const std::byte> bytes) {
  const internal::Program& program = diagram_->program();
  internal::Archive archive;
  archive.Write(bytes.data(), bytes.size());
  std::uint64_t signature = 0;
  internal::Load(signature, archive);
  if (signature != program.signature) {
    throw RunError("the snapshot is of another diagram: restore it into the one that it was saved from");
  }
  double time = 0;
  internal::Load(time, archive);
  internal::Load(seed_, archive);
  internal::Load(progress_, archive);
  internal::Load(next_step_, archive);
  internal::Load(last_error_, archive);
  SetTime(time);
  failure_.clear();
  internal::Load(step_start_.valid, archive);
  if (step_start_.valid) {
    internal::Load(internal::TypeInfoOf<StepStart>(), &step_start_, archive);
    if (step_start_.states.size() != static_cast<std::size_t>(program.num_continuous)) {
      throw RunError("the snapshot is damaged: its states are not as many as the diagram's");
    }
  }
  for (const Cell& cell : program.saved) {
    bool fresh = false;
    internal::Load(fresh, archive);
    internal::Load(*cell.source->type_, memory_.get() + cell.offset, archive);
    const int calculation = cell.source->calculation_;
    if (calculation < 0) continue;
    const std::uint64_t stamp = program.calculations[calculation].varies ? instant_ : 1;
    stamps_[calculation] = fresh ? stamp : 0;
  }
  for (std::size_t i = 0; i < fixed_.size(); ++i) {
    bool fixed = false;
    internal::Load(fixed, archive);
    fixed_[i] = fixed;
  }
  PackStates();
  if (!archive.exhausted()) throw RunError("the snapshot is longer than this diagram's: it is damaged");
}

void Context::SaveFile(const std::string& file) const {
  const std::vector<std::byte> bytes = Save();
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw RunError(fmt::format("cannot write the snapshot to '{}'", file));
}

void Context::RestoreFile(const std::string& file) {
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) throw RunError(fmt::format("cannot read the snapshot '{}'", file));
  std::vector<std::byte> bytes(static_cast<std::size_t>(in.tellg()));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  try {
    Restore(bytes);
  } catch (const Error& error) {
    throw RunError(fmt::format("cannot restore '{}': {}", file, error.what()));
  }
}

}  // namespace tenon
