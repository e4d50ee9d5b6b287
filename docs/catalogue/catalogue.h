#pragma once

#include <tenon/systems/simulation.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tenon::docs {

/// One block or diagram that Tenon offers, made with the parameters that ship.
struct Entry {
  std::string title;  ///< as one writes it: "Gain<T>", "TrunkImu"
  std::string name;   ///< of its class
  std::unique_ptr<System> block;
  /// What stands for a type that a template's argument has put into the block: {"Vec<7>", "T"}.
  std::vector<std::pair<std::string, std::string>> placeholders = {};
  std::string note = {};  ///< a sentence that the block itself cannot tell
};

/// Blocks that stand together on the page; the page's template says `{{name}}` where.
struct Shelf {
  std::string name;
  std::vector<Entry> entries;
};

/// All of them.
std::vector<Shelf> MakeCatalogue();

/// A diagram as Graphviz draws it.
struct Picture {
  std::string name;      ///< of the file, without its ending
  std::string graphviz;  ///< what Diagram::Graphviz() writes
};

/// Pictures of the shipped diagrams.
std::vector<Picture> MakePictures();

}  // namespace tenon::docs
