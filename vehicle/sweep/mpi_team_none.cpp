// Built without MPI.

#include "vehicle/sweep/mpi_team.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

MpiSession::MpiSession() {
  throw UsageError(
      "sweep: expected a program built with MPI under mpirun, found one without (Debian: libopenmpi-dev; then "
      "configure "
      "with -DUICLINK_MPI=ON)");
}
MpiSession::~MpiSession() = default;
int MpiSession::rank() const { return 0; }
int MpiSession::size() const { return 1; }
std::string MpiSession::Broadcast(const std::string& text) const { return text; }
bool MpiSession::SameEverywhere(const std::string& /*text*/) const { return true; }
std::unique_ptr<Team> MpiSession::MakeTeam(const SweepPlan& plan, int threads) {
  return std::make_unique<LocalTeam>(plan, threads);
}
void MpiSession::Serve(const SweepPlan& /*plan*/, int /*threads*/) {}

}  // namespace uiclink
