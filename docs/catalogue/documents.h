#pragma once

#include <tenon/docs/catalogue/catalogue.h>

#include <filesystem>
#include <string>

namespace tenon::docs {

/// docs/blocks.md, of the source tree at `source`.
std::string WriteBlocks(const std::filesystem::path& source);

/// Draws a picture as `directory`/NAME.svg, by Graphviz's `dot`. Throws Error if that fails.
void Draw(const Picture& picture, const std::filesystem::path& directory);

/// Whether Draw would draw `directory`/NAME.svg anew: its last line tells what it was drawn from.
bool IsUpToDate(const Picture& picture, const std::filesystem::path& directory);

}  // namespace tenon::docs
