#pragma once

#include <tenon/docs/catalogue/catalogue.h>
#include <tenon/docs/catalogue/headers.h>

#include <map>
#include <string>
#include <vector>

namespace tenon::docs {

/// Returns the text of docs/blocks.md: the template `text` with a table of ports for every block, and a table
/// of the types of their signals. Throws Error if the template has no placeholder for a shelf, or if no
/// public header declares a block.
std::string WritePage(const std::string& text, const std::vector<Shelf>& catalogue,
                      const std::map<std::string, Declaration>& declarations);

}  // namespace tenon::docs
