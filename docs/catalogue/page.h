#pragma once

#include <tenon/docs/catalogue/catalogue.h>
#include <tenon/docs/catalogue/headers.h>

#include <map>
#include <string>
#include <vector>

namespace tenon::docs {

/// docs/blocks.md: the template with a table of ports for every block, and one of the types that they carry.
/// Throws Error if a shelf has no place in the template, or a block is not declared in a public header.
std::string WritePage(const std::string& text, const std::vector<Shelf>& catalogue,
                      const std::map<std::string, Declaration>& declarations);

}  // namespace tenon::docs
