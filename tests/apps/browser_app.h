#pragma once

#include <tenon/tests/systems/report/browser.h>

#include <gtest/gtest.h>

#include <cstdlib>

namespace tenon::test {

/// Skips the test if Chromium is not installed, or fails it if TENON_REQUIRE_BROWSER is set. Call it in
/// SetUp.
inline void RequireBrowser() {
  if (testing::Browser::IsInstalled()) return;
  if (std::getenv("TENON_REQUIRE_BROWSER") != nullptr) FAIL() << "chromium is missing: tools/install_deps";
  GTEST_SKIP() << "needs chromium";
}

}  // namespace tenon::test
