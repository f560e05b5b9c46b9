#pragma once

#include <memory>
#include <type_traits>

struct _SUNContext;
struct _generic_N_Vector;
struct ARKodeButcherTableMem;

namespace uiclink {

/// Frees what SUNDIALS has made.
struct FreeSundials {
  void operator()(_SUNContext* context) const;
  void operator()(_generic_N_Vector* vector) const;
  void operator()(ARKodeButcherTableMem* table) const;
  void operator()(void* erk_step) const;  ///< of ERKStepCreate()
};

/// Owner of a SUNDIALS handle: Owner<N_Vector>, Owner<void*>.
template <typename Handle>
using Owner = std::unique_ptr<std::remove_pointer_t<Handle>, FreeSundials>;

/// @throws std::runtime_error when there is no memory.
Owner<_SUNContext*> MakeSundialsContext();

}  // namespace uiclink
