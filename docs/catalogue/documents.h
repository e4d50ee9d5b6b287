#pragma once

#include <tenon/docs/catalogue/catalogue.h>

#include <filesystem>
#include <string>

namespace tenon::docs {

/// The text of docs/blocks.md for the source tree at `source`.
std::string WriteBlocks(const std::filesystem::path& source);

/// Draws a picture as `directory`/NAME.svg, by Graphviz's `dot`. Throws Error if that fails.
void Draw(const Picture& picture, const std::filesystem::path& directory);

/// Returns whether `directory`/NAME.svg shows this diagram, by the hash in its last line.
bool IsUpToDate(const Picture& picture, const std::filesystem::path& directory);

}  // namespace tenon::docs
