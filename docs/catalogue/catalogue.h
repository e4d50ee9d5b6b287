#pragma once

#include <tenon/systems/simulation.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tenon::docs {

/// One public block or diagram, created with the shipped parameters.
struct Entry {
  std::string title;  ///< name as in source code: "Gain<T>", "TrunkImu"
  std::string name;   ///< name of the class
  std::unique_ptr<System> block;
  /// Types that come from a template's argument, and the names to show instead: {"Vec<7>", "T"}.
  std::vector<std::pair<std::string, std::string>> placeholders = {};
  std::string note = {};           ///< an additional sentence about the block
  int size = 4;                    ///< size of the vectors that it reads, where only the run knows it
  std::vector<Field> ranges = {};  ///< the members of the block's parameters that it checks
  /// Builds a diagram of the block alone, named "block", with open inputs. `change` changes its parameters in
  /// place before, unless it is empty.
  std::function<std::shared_ptr<const Diagram>(const std::function<void(void* params)>& change)> build = {};
};

/// Blocks of one section of the page; the placeholder `{{name}}` in the template marks its place.
struct Shelf {
  std::string name;
  std::vector<Entry> entries;

  Entry& Put(Entry entry, std::string note = {}) {
    entry.note = std::move(note);
    return entries.emplace_back(std::move(entry));
  }
};

/// Returns all public blocks and diagrams, by section.
std::vector<Shelf> MakeCatalogue();

/// A diagram to be drawn by Graphviz.
struct Picture {
  std::string name;      ///< file name without extension
  std::string graphviz;  ///< output of Diagram::Graphviz()
};

/// Returns the pictures of the shipped diagrams.
std::vector<Picture> MakePictures();

}  // namespace tenon::docs
