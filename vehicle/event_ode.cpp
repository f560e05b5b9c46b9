#include "vehicle/event_ode.h"

#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "vehicle/sundials_memory.h"

namespace uiclink {
namespace {

class Run {
 public:
  Run(const EventOde& ode, std::span<const double> start, const EventOdeOptions& options)
      : ode_(ode), crossed_(ode.guards) {
    if (start.size() != ode.size) throw std::invalid_argument("SolveEventOde: start has the wrong size");
    if (options.atol.size() != 1 && options.atol.size() != ode.size)
      throw std::invalid_argument("SolveEventOde: atol must have one number or one for each component");
    y_ = NewVector();
    std::copy(start.begin(), start.end(), Data(y_.get()));
    atol_ = NewVector();
    for (std::size_t i = 0; i < ode.size; ++i) Data(atol_.get())[i] = options.atol[options.atol.size() == 1 ? 0 : i];
    arkode_.reset(ERKStepCreate(&Rate, 0, y_.get(), context_.get()));
    if (!arkode_) throw std::runtime_error("SolveEventOde: ERKStepCreate failed");
    Check(ERKStepSetErrHandlerFn(arkode_.get(), &KeepMessage, this));
    Check(ERKStepSetUserData(arkode_.get(), this));
    Check(ERKStepSVtolerances(arkode_.get(), options.rtol, atol_.get()));
    Check(ERKStepSetOrder(arkode_.get(), 5));
    Check(ERKStepSetMaxNumSteps(arkode_.get(), -1));
    if (options.max_step > 0) Check(ERKStepSetMaxStep(arkode_.get(), options.max_step));
    if (ode.guards > 0) {
      Check(ERKStepRootInit(arkode_.get(), static_cast<int>(ode.guards), &Guard));
      Check(ERKStepSetNoInactiveRootWarn(arkode_.get()));
    }
  }

  std::span<double> y() { return {Data(y_.get()), ode_.size}; }

  /// Up to t_end exactly, through all events on the way.
  void Advance(double t_end) {
    while (t_ < t_end) {
      Check(ERKStepSetStopTime(arkode_.get(), t_end));
      const int flag = ERKStepEvolve(arkode_.get(), t_end, y_.get(), &t_, ARK_NORMAL);
      Check(flag);
      if (flag != ARK_ROOT_RETURN) return;
      Check(ERKStepGetRootInfo(arkode_.get(), crossed_.data()));
      ++events_;
      ode_.pass(t_, y(), crossed_);
      Check(ERKStepReset(arkode_.get(), t_, y_.get()));
    }
  }

  EventOdeCounts Counts() const {
    EventOdeCounts counts{.events = events_};
    ERKStepGetNumSteps(arkode_.get(), &counts.steps);
    ERKStepGetNumRhsEvals(arkode_.get(), &counts.rate_calls);
    return counts;
  }

 private:
  static double* Data(N_Vector vector) { return N_VGetArrayPointer(vector); }
  static const Run& Self(void* self) { return *static_cast<const Run*>(self); }
  Owner<N_Vector> NewVector() const {
    return Owner<N_Vector>(N_VNew_Serial(static_cast<sunindextype>(ode_.size), context_.get()));
  }
  void Check(int flag) const {
    if (flag < 0) throw std::runtime_error("SolveEventOde: " + message_);
  }

  static int Rate(realtype t, N_Vector y, N_Vector rate, void* self) {
    const EventOde& ode = Self(self).ode_;
    ode.rate(t, {Data(y), ode.size}, {Data(rate), ode.size});
    return 0;
  }
  static int Guard(realtype t, N_Vector y, realtype* guards, void* self) {
    const EventOde& ode = Self(self).ode_;
    ode.guard(t, {Data(y), ode.size}, {guards, ode.guards});
    return 0;
  }
  static void KeepMessage(int, const char*, const char*, char* message, void* self) {
    static_cast<Run*>(self)->message_ = message;
  }

  const EventOde& ode_;
  Owner<SUNContext> context_ = MakeSundialsContext();
  Owner<N_Vector> y_, atol_;
  Owner<void*> arkode_;
  std::vector<int> crossed_;
  std::string message_ = "out of memory";
  double t_ = 0;
  long events_ = 0;
};

}  // namespace

EventOdeCounts SolveEventOde(const EventOde& ode, std::span<const double> start, double step, std::size_t samples,
                             const std::function<void(std::size_t i, double t, std::span<const double> y)>& sample,
                             const EventOdeOptions& options) {
  Run run(ode, start, options);
  for (std::size_t i = 0; i < samples; ++i) {
    const double t = static_cast<double>(i) * step;
    run.Advance(t);
    sample(i, t, run.y());
  }
  return run.Counts();
}

}  // namespace uiclink
