#pragma once

#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

namespace tenon::test {

/// The figures of a run, read from its summary.json.
struct Case {
  double operator[](const char* key) const { return summary.at(key).get<double>(); }
  bool finished() const { return summary.at("finished").get<bool>(); }
  double largest_foot_error() const {
    double largest = 0;
    for (const auto& error : summary.at("foot_error_max_m"))
      if (!error.is_null()) largest = std::max(largest, error.get<double>());
    return largest;
  }
  nlohmann::json summary;
};

/// A test of the goals of the shipped cases, which runs the apps as a user does.
struct CaseTest : AppTest {
  /// Runs a scenario to its end or to a fall. The arguments may override its keys.
  Case Run(const std::string& app, const std::string& arguments) const {
    const Result result = RunCommand(app + " " + arguments + Out());
    EXPECT_TRUE(result.exit_code == 0 || result.exit_code == 3) << arguments << ": " << result.text;
    return {nlohmann::json::parse(Summary())};
  }
};

}  // namespace tenon::test
