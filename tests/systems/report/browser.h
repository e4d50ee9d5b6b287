#pragma once

#include <tenon/systems/report/internal/browser.h>

#include <gtest/gtest.h>

#include <cstdlib>

namespace tenon::testing {

/// A new browser for each test, without a sandbox, which containers may lack.
struct Browser : internal::Browser {
  explicit Browser(std::vector<std::string> arguments = {})
      : internal::Browser((arguments.emplace_back("--no-sandbox"), arguments)) {}
};

/// For SetUp(): skips the test if Chromium is not installed, or lets it fail if TENON_REQUIRE_BROWSER is set.
inline void RequireBrowser() {
  if (Browser::IsInstalled()) return;
  if (std::getenv("TENON_REQUIRE_BROWSER") != nullptr) FAIL() << "chromium is missing: tools/install_deps";
  GTEST_SKIP() << "needs chromium";
}

/// A test of a page in a browser.
struct BrowserTest : ::testing::Test {
  void SetUp() override { RequireBrowser(); }
  nlohmann::json Js(const std::string& expression) { return browser.Evaluate(expression); }
  Browser browser;
};

}  // namespace tenon::testing
