#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <string>

namespace tenon {

/// Succeeds if `call` throws an ErrorType, or a type derived from it, whose text contains all `parts`. The
/// failure message says what happened instead, with the actual text.
///
///     EXPECT_TRUE(Throws<ParameterError>([] { Pd pd({.kp = -1}); }, "kp", "positive"));
template <class ErrorType = std::exception, class F, class... Parts>
::testing::AssertionResult Throws(F&& call, const Parts&... parts) {
  try {
    call();
  } catch (const ErrorType& error) {
    const std::string text = error.what();
    std::string missing;
    for (const std::string& part : {std::string(parts)..., std::string()}) {
      if (text.find(part) == std::string::npos) missing += (missing.empty() ? "'" : ", '") + part + "'";
    }
    if (missing.empty()) return ::testing::AssertionSuccess() << "it throws: " << text;
    return ::testing::AssertionFailure() << "the message lacks " << missing << "; it reads: " << text;
  } catch (const std::exception& error) {
    return ::testing::AssertionFailure() << "an error of another type is thrown; it reads: " << error.what();
  } catch (...) {
    return ::testing::AssertionFailure() << "something that is no std::exception is thrown";
  }
  return ::testing::AssertionFailure() << "nothing is thrown";
}

}  // namespace tenon
