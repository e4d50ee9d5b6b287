#pragma once

#include <tenon/systems/simulation.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tenon::docs {

/// One block or diagram of the library, made with shipped parameters.
struct Entry {
  std::string title;  ///< name in code: "Gain<T>", "TrunkImu"
  std::string name;   ///< name of its class
  std::unique_ptr<System> block;
  /// Names of types that depend on a template argument, by the type in the block: {"Vec<7>", "T"}.
  std::vector<std::pair<std::string, std::string>> placeholders = {};
  std::string note = {};  ///< an additional sentence on the page
};

/// Blocks of one section of the page, which replaces `{{name}}` in the page's template.
struct Shelf {
  std::string name;
  std::vector<Entry> entries;
};

/// All blocks and diagrams of the library.
std::vector<Shelf> MakeCatalogue();

/// The picture of a diagram.
struct Picture {
  std::string name;      ///< name of the file without extension
  std::string graphviz;  ///< output of Diagram::Graphviz()
};

/// Pictures of the shipped diagrams.
std::vector<Picture> MakePictures();

}  // namespace tenon::docs
