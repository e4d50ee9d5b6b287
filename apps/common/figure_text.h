#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tenon::apps {

/// Figures by name with their values as text, as Summary::Flat gives them.
using NamedTexts = std::vector<std::pair<std::string, std::string>>;

/// A figure formatted for a terminal.
struct FigureText {
  std::string key;  ///< key in summary.json: foot_error_max_m
  /// Values with their names, for example one for each leg; the name of a single value is empty.
  NamedTexts values;
  std::string unit = {};   ///< printed after the values; empty for a text
  std::string limit = {};  ///< printed at the end of the line
};

/// Formats a number with four significant digits, without exponent from 0.0001 to 10 million, and integers
/// with all digits. Infinities and NaN become "-".
std::string NumberText(double value);

/// Groups entries such as "foot_error_max_m.front_left" into one figure "foot_error_max_m" and formats
/// numbers by NumberText. An empty text becomes "-".
std::vector<FigureText> FigureTexts(const NamedTexts& flat);

/// Formats a line for each figure; figures with a value for each leg come last, as a table with a column for
/// each leg.
std::string FigureLines(const std::vector<FigureText>& figures);

/// Formats a line for each figure of several runs, with a column for each run. Runs that do not fit into 120
/// characters follow in another table. Long texts are truncated.
std::string FigureColumns(const std::vector<std::pair<std::string, NamedTexts>>& runs);

/// Formats a value and its limit with enough digits, at least `digits`, to distinguish them.
std::pair<std::string, std::string> Beside(double value, double limit, int digits = 3);

}  // namespace tenon::apps
