#pragma once

namespace tenon {

/// Returns the version of the library and, if it was built in a clone of the repository, the commit: "0.3.0
/// (commit 0123456789ab)", or "0.3.0 (commit 0123456789ab with changes)" if tracked files differed from it.
const char* Version();

}  // namespace tenon
