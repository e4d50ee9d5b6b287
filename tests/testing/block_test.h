#pragma once

// The helpers that the test of a block needs.
#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/refuses.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>
