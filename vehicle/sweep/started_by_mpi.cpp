#include <cstdlib>

#include "vehicle/sweep/mpi_team.h"

namespace uiclink {

bool StartedByMpi() {
  // Open MPI; MPICH and its kin; any starter that speaks PMIx.
  for (const char* const variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"}) {
    if (std::getenv(variable) != nullptr) return true;
  }
  return false;
}

}  // namespace uiclink
