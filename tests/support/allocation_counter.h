#pragma once

#include <cstddef>

namespace uiclink {

/// Number of allocations by `operator new` since the program started.  A program that calls this has its operators new
/// and delete replaced by counting ones; memory that C libraries take with malloc is not seen.
std::size_t CountAllocations();

}  // namespace uiclink
