#include "tests/support/link_swing.h"

#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>

#include <stdexcept>
#include <string>

namespace uiclink {
namespace {

constexpr int kMostChanges = 8;  // at one place: breaking out, and sticking at once, of few joints

void Check(int flag, const char* what) {
  if (flag < 0) throw std::runtime_error(std::string("SwingLink: ") + what + " returned " + std::to_string(flag));
}

class Swing {
 public:
  Swing(const Link& link, LinkState* state, double y0, double v0, const LinkSwingOptions& options)
      : link_(link), state_(*state), options_(options), mass_(link.load() / link.law().g) {
    Check(SUNContext_Create(nullptr, &context_), "SUNContext_Create");
    x_ = N_VNew_Serial(2, context_);
    sample_ = N_VNew_Serial(2, context_);
    NV_Ith_S(x_, 0) = y0;
    NV_Ith_S(x_, 1) = v0;
    erk_ = ERKStepCreate(&Rhs, 0, x_, context_);
    Check(ERKStepSetUserData(erk_, this), "ERKStepSetUserData");
    Check(ERKStepSetOrder(erk_, 5), "ERKStepSetOrder");
    Check(ERKStepSetInterpolantDegree(erk_, 5), "ERKStepSetInterpolantDegree");
    Check(ERKStepSStolerances(erk_, options.tolerance, 1e-2 * options.tolerance), "ERKStepSStolerances");
    Check(ERKStepSetMaxNumSteps(erk_, 10000000), "ERKStepSetMaxNumSteps");
    Check(ERKStepSetMaxStep(erk_, options.max_step), "ERKStepSetMaxStep");
    Check(ERKStepRootInit(erk_, 1, &Margin), "ERKStepRootInit");
    int falling = -1;
    Check(ERKStepSetRootDirection(erk_, &falling), "ERKStepSetRootDirection");
    Check(ERKStepSetNoInactiveRootWarn(erk_), "ERKStepSetNoInactiveRootWarn");
  }
  Swing(const Swing&) = delete;
  Swing& operator=(const Swing&) = delete;
  ~Swing() {
    ERKStepFree(&erk_);
    N_VDestroy(x_);
    N_VDestroy(sample_);
    SUNContext_Free(&context_);
  }

  LinkSwingCounts Go(const SampleTimes& times, std::span<double> y) {
    std::size_t next = 0;
    for (; next < times.size && times[next] <= 0; ++next) y[next] = NV_Ith_S(x_, 0);
    SwitchJoints();  // of a start on a threshold
    double t = 0;
    while (next < times.size) {
      const int flag = ERKStepEvolve(erk_, times[times.size - 1], x_, &t, ARK_ONE_STEP);
      Check(flag, "ERKStepEvolve");
      ++counts_.steps;
      for (; next < times.size && times[next] <= t; ++next) {
        Check(ERKStepGetDky(erk_, times[next], 0, sample_), "ERKStepGetDky");
        y[next] = NV_Ith_S(sample_, 0);
      }
      if (flag != ARK_ROOT_RETURN) continue;
      ++(SwitchJoints() ? counts_.changes : counts_.turns);
      Check(ERKStepReset(erk_, t, x_), "ERKStepReset");
    }
    return counts_;
  }

 private:
  double Acceleration(double y, double v) const { return state_.CalcForce(link_, y, v) / mass_; }

  bool SwitchJoints() {
    const double y = NV_Ith_S(x_, 0), v = NV_Ith_S(x_, 1);
    for (int change = 0; change < kMostChanges; ++change) {
      const LinkState before = state_;
      if (!state_.Switch(link_, y, v, Acceleration(y, v))) return change > 0;
      if (options_.on_switch) options_.on_switch(before, state_, y, v);
    }
    throw std::runtime_error("SwingLink: the joints change for ever");
  }

  static int Rhs(realtype /*t*/, N_Vector x, N_Vector f, void* self) {
    NV_Ith_S(f, 0) = NV_Ith_S(x, 1);
    NV_Ith_S(f, 1) = static_cast<const Swing*>(self)->Acceleration(NV_Ith_S(x, 0), NV_Ith_S(x, 1));
    return 0;
  }

  static int Margin(realtype /*t*/, N_Vector x, realtype* margin, void* self) {
    const Swing& swing = *static_cast<const Swing*>(self);
    const double y = NV_Ith_S(x, 0), v = NV_Ith_S(x, 1);
    const double a = swing.link_.needs_acceleration() ? swing.Acceleration(y, v) : 0;
    *margin = swing.state_.CalcMargin(swing.link_, y, v, a);
    return 0;
  }

  const Link& link_;
  LinkState& state_;
  const LinkSwingOptions& options_;
  double mass_;
  LinkSwingCounts counts_;
  SUNContext context_ = nullptr;
  N_Vector x_ = nullptr, sample_ = nullptr;
  void* erk_ = nullptr;
};

}  // namespace

LinkSwingCounts SwingLink(const Link& link, LinkState* state, double y0, double v0, const SampleTimes& times,
                          std::span<double> y, const LinkSwingOptions& options) {
  return Swing(link, state, y0, v0, options).Go(times, y);
}

}  // namespace uiclink
