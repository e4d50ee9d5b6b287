#pragma once

#include <tenon/docs/catalogue/catalogue.h>

#include <filesystem>
#include <string>

namespace tenon::docs {

/// Returns the text of docs/blocks.md for the source tree at `source`.
std::string WriteBlocks(const std::filesystem::path& source);

/// Draws a picture with Graphviz's `dot` and writes `directory`/NAME.svg. Throws Error if that fails.
void Draw(const Picture& picture, const std::filesystem::path& directory);

/// Whether `directory`/NAME.svg shows the current diagram: its last line has a hash of the diagram that was
/// drawn.
bool IsUpToDate(const Picture& picture, const std::filesystem::path& directory);

}  // namespace tenon::docs
