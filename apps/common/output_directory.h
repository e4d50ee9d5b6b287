#pragma once

#include <tenon/systems/framework/diagram/diagram.h>

#include <filesystem>

namespace tenon::apps {

/// Creates a directory if necessary and locks it for this process during the lifetime of the object.
class OutputLock {
 public:
  /// Throws OutputError if the directory cannot be created, and ParameterError if another run has locked it.
  explicit OutputLock(std::filesystem::path path);
  ~OutputLock();
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_;  ///< file descriptor; the system releases the lock when the process ends
};

/// Returns whether a variant of a run may have this name, which is also its subdirectory: it has no '/', does
/// not begin with '.', and has at most 200 bytes.
bool IsVariantName(std::string_view name);

/// The locked output directory of a run. The constructor removes the files that an earlier run and its
/// variants left, so that the directory never mixes the files of two runs. It keeps `files` and live.jsonl,
/// which the new run may read; the code that writes these removes the old ones first.
class OutputDirectory : public OutputLock {
 public:
  /// Throws as OutputLock does.
  explicit OutputDirectory(std::filesystem::path path);
};

/// Writes the diagram to a file, as SVG by Graphviz's `dot` or as .dot; does nothing if `file` is empty.
/// Throws ParameterError for another extension or if `dot` is missing, and OutputError if the file cannot be
/// written.
void WriteGraph(const Diagram& diagram, const std::filesystem::path& file);

/// Runs a program of the PATH without a shell. Returns its exit code, or nothing if it is not installed.
/// Throws OutputError if it cannot be started.
std::optional<int> RunProgram(std::vector<std::string> arguments);

}  // namespace tenon::apps
