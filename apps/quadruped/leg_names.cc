#include <tenon/apps/quadruped/leg_names.h>

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

namespace tenon {
namespace {

/// Splits a name at everything that is no letter and before capitals that follow small letters, in small
/// letters.
std::vector<std::string> Words(const std::string& name) {
  std::vector<std::string> words(1);
  char before = 0;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalpha(letter) == 0 || (std::isupper(letter) != 0 && std::islower(before) != 0))
      words.emplace_back();
    if (std::isalpha(letter) != 0) words.back() += static_cast<char>(std::tolower(letter));
    before = c;
  }
  return words;
}

}  // namespace

LegPlace PlaceInName(const std::string& name) {
  LegPlace place;
  for (const std::string& word : Words(name)) {
    const auto has = [&](std::string_view part) { return word.find(part) != word.npos; };
    if (has("front") || has("fore")) place.front = 1;
    if (has("rear") || has("back") || has("hind")) place.front = -1;
    if (has("left")) place.left = 1;
    if (has("right")) place.left = -1;
    if (word.size() != 2) continue;  // two letters, such as fl or hr, in either order
    for (std::string pair : {word, std::string(word.rbegin(), word.rend())}) {
      if (std::string_view("fbh").find(pair[0]) == std::string_view::npos && pair[0] != 'r') continue;
      if (pair[1] != 'l' && pair[1] != 'r') continue;
      place.front = pair[0] == 'f' ? 1 : -1;
      place.left = pair[1] == 'l' ? 1 : -1;
      break;
    }
  }
  return place;
}

}  // namespace tenon
