#include "vehicle/sundials_memory.h"

#include <arkode/arkode_erkstep.h>

#include <stdexcept>

namespace uiclink {

void FreeSundials::operator()(SUNContext context) const { SUNContext_Free(&context); }
void FreeSundials::operator()(N_Vector vector) const { N_VDestroy(vector); }
void FreeSundials::operator()(ARKodeButcherTable table) const { ARKodeButcherTable_Free(table); }
void FreeSundials::operator()(void* erk_step) const { ERKStepFree(&erk_step); }

Owner<SUNContext> MakeSundialsContext() {
  SUNContext context = nullptr;
  if (SUNContext_Create(nullptr, &context) != 0) throw std::runtime_error("there is no memory for SUNDIALS");
  return Owner<SUNContext>(context);
}

}  // namespace uiclink
