#pragma once

struct _generic_N_Vector;
struct _SUNContext;

namespace uiclink {

/// A serial vector of SUNDIALS of kMaxState components, whose sums and norms are ours: of fixed length and in vectors
/// of four doubles. SUNDIALS' own take twice as long as the right-hand side.  Null when there is no memory.
_generic_N_Vector* NewStateVector(_SUNContext* context);

}  // namespace uiclink
