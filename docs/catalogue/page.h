#pragma once

#include <tenon/docs/catalogue/catalogue.h>
#include <tenon/docs/catalogue/headers.h>

#include <map>
#include <string>
#include <vector>

namespace tenon::docs {

/// The text of docs/blocks.md: the template `text` with a table of ports for each block, and a table of their
/// types. Throws Error if the template has no place for a shelf, or a block is not declared in a public
/// header.
std::string WritePage(const std::string& text, const std::vector<Shelf>& catalogue,
                      const std::map<std::string, Declaration>& declarations);

}  // namespace tenon::docs
