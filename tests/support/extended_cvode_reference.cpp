#include "tests/support/extended_cvode_reference.h"

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace uiclink {
namespace {

void Check(int flag, const char* what) {
  if (flag < 0)
    throw std::runtime_error(std::string("RunExtendedCvode: ") + what + " returned " + std::to_string(flag));
}

class Run {
 public:
  Run(const ExtendedOscillator<double>& oscillator, double y0, std::span<const double> deflection, double clock)
      : o_(oscillator), clock_(clock), d_(y0 < 0 ? -1 : 1) {
    const auto sliders = o_.sliders.items();
    for (std::size_t i = 0; i < sliders.size(); ++i) sliders_.push_back({.p = y0 - d_ * deflection[i]});
    Check(SUNContext_Create(nullptr, &context_), "SUNContext_Create");
    x_ = N_VNew_Serial(2, context_);
    Y() = y0;
    V() = 0;
    cvode_ = CVodeCreate(CV_ADAMS, context_);
    Check(CVodeInit(cvode_, &Rhs, 0, x_), "CVodeInit");
    Check(CVodeSStolerances(cvode_, 1e-12, 1e-14), "CVodeSStolerances");
    Check(CVodeSetUserData(cvode_, this), "CVodeSetUserData");
    Check(CVodeSetMaxNumSteps(cvode_, 1000000), "CVodeSetMaxNumSteps");
    // Longer steps might jump over a slip that begins and ends between two of them.
    Check(CVodeSetMaxStep(cvode_, 0.01), "CVodeSetMaxStep");
    Check(CVodeRootInit(cvode_, GuardCount(), &Guards), "CVodeRootInit");
    Check(CVodeSetNoInactiveRootWarn(cvode_), "CVodeSetNoInactiveRootWarn");
    corrector_ = SUNNonlinSol_FixedPoint(x_, 0, context_);
    Check(CVodeSetNonlinearSolver(cvode_, corrector_), "CVodeSetNonlinearSolver");
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;
  ~Run() {
    CVodeFree(&cvode_);
    SUNNonlinSolFree(corrector_);
    N_VDestroy(x_);
    SUNContext_Free(&context_);
  }

  ExtendedCvodeCounts Go(const SampleTimes& times, std::span<double> y) {
    std::size_t next = 0;
    for (; next < times.size && times[next] <= 0; ++next) y[next] = Y();
    double t = 0;
    LeaveRest(t);
    N_Vector sample = N_VNew_Serial(2, context_);
    while (next < times.size && !held_) {
      const int flag = CVode(cvode_, times[times.size - 1], x_, &t, CV_ONE_STEP);
      Check(flag, "CVode");
      ++counts_.steps;
      for (; next < times.size && times[next] <= t; ++next) {
        Check(CVodeGetDky(cvode_, times[next], 0, sample), "CVodeGetDky");
        y[next] = NV_Ith_S(sample, 0);
      }
      if (flag == CV_ROOT_RETURN) PassEvents(t);
    }
    N_VDestroy(sample);
    for (; next < times.size; ++next) y[next] = Y();
    return counts_;
  }

 private:
  struct Slider {
    double p = 0;
    bool slides = false;
  };

  double& Y() { return NV_Ith_S(x_, 0); }
  double& V() { return NV_Ith_S(x_, 1); }
  int GuardCount() const { return static_cast<int>(1 + 3 * o_.sliders.size() + o_.stops.size()); }
  double Gap(std::size_t i) const { return o_.sliders.items()[i].joint ? o_.gap : 0; }

  /// S of slider i at displacement y.
  double Stretch(std::size_t i, double y) const {
    const double z = y - sliders_[i].p, gap = Gap(i);
    return z > gap ? z - gap : z < -gap ? z + gap : 0;
  }

  double Limit(std::size_t i, double t, double speed, bool slides) const {
    const ExtendedSlider<double>& slider = o_.sliders.items()[i];
    if (!slider.joint) return slider.y_c;
    double share = 1 + o_.strengthening * speed;
    for (const SpeedTerm<double>& term : o_.speed_terms.items())
      share += slides ? term.sliding(term.p, speed) : term.sticking(term.p);
    return slider.y_c * share * (1 + o_.drift * (clock_ + t)) * (1 + d_ * o_.asymmetry);
  }

  double Acceleration(double t, double y, double v) const {
    double force = -o_.k * y - o_.damping * v - d_ * o_.rolling;
    for (std::size_t i = 0; i < sliders_.size(); ++i)
      force -= o_.sliders.items()[i].k * (sliders_[i].slides ? d_ * Limit(i, t, d_ * v, true) : Stretch(i, y));
    for (const Stop<double>& stop : o_.stops.items())
      if ((y - stop.position) * stop.position > 0) force -= stop.k * (y - stop.position);
    for (const ForceTerm<double>& term : o_.forces.items()) force += term.force(term.p, {clock_ + t, y, v});
    return o_.g * force;
  }

  /// d p' of a joint that slides, p = y - d (limit + gap).
  double SlidingSpeed(std::size_t i, double t, double y, double v) const {
    if (!o_.sliders.items()[i].joint || o_.speed_terms.empty()) return 1;
    const double h = 1e-7, a = Acceleration(t, y, v);
    const double growth = (Limit(i, t, d_ * v + h, true) - Limit(i, t, d_ * v - h, true)) / (2 * h);
    return d_ * v - growth * d_ * a;
  }

  void PassEvents(double t) {
    std::vector<int> roots(static_cast<std::size_t>(GuardCount()));
    Check(CVodeGetRootInfo(cvode_, roots.data()), "CVodeGetRootInfo");
    for (std::size_t i = 0; i < sliders_.size(); ++i) {
      if (roots[1 + i] == 0) continue;
      if (sliders_[i].slides) {
        Stick(i, t, d_ * V());
        ++counts_.stickings;
      } else {
        sliders_[i].slides = true;
        ++counts_.breakouts;
        // Freed late in a half swing its limit may run away at once: it has only jumped.
        if (SlidingSpeed(i, t, Y(), V()) < 0) Stick(i, t, d_ * V());
      }
    }
    if (roots[0] != 0) {
      ++counts_.turnings;
      V() = 0;
      for (std::size_t i = 0; i < sliders_.size(); ++i)
        if (sliders_[i].slides) Stick(i, t, 0);
      LeaveRest(t);
    }
    Check(CVodeReInit(cvode_, t, x_), "CVodeReInit");
  }

  void Stick(std::size_t i, double t, double speed) {
    sliders_[i].p = Y() - d_ * (Limit(i, t, speed, true) + Gap(i));
    sliders_[i].slides = false;
  }

  /// From rest the mass goes where the force points, unless friction on it holds it.
  void LeaveRest(double t) {
    const double force = Acceleration(t, Y(), 0) / o_.g + d_ * o_.rolling;
    held_ = std::abs(force) <= o_.rolling;
    d_ = force < 0 ? -1 : 1;
  }

  static int Rhs(realtype t, N_Vector x, N_Vector f, void* self) {
    NV_Ith_S(f, 0) = NV_Ith_S(x, 1);
    NV_Ith_S(f, 1) = static_cast<const Run*>(self)->Acceleration(t, NV_Ith_S(x, 0), NV_Ith_S(x, 1));
    return 0;
  }

  static int Guards(realtype t, N_Vector x, realtype* guards, void* self) {
    const Run& run = *static_cast<const Run*>(self);
    const double y = NV_Ith_S(x, 0), v = NV_Ith_S(x, 1);
    const std::size_t n = run.sliders_.size();
    *guards++ = run.d_ * v;
    for (std::size_t i = 0; i < n; ++i)
      *guards++ = run.sliders_[i].slides
                      ? run.SlidingSpeed(i, t, y, v)
                      : run.Limit(i, t, std::max(0.0, run.d_ * v), false) - run.d_ * run.Stretch(i, y);
    for (std::size_t i = 0; i < n; ++i) {
      const bool kinks = run.Gap(i) > 0 && !run.sliders_[i].slides;
      *guards++ = kinks ? y - run.sliders_[i].p - run.Gap(i) : 1;
      *guards++ = kinks ? y - run.sliders_[i].p + run.Gap(i) : 1;
    }
    for (const Stop<double>& stop : run.o_.stops.items()) *guards++ = y - stop.position;
    return 0;
  }

  const ExtendedOscillator<double>& o_;
  double clock_;
  double d_;  // direction of travel
  bool held_ = false;
  std::vector<Slider> sliders_;
  ExtendedCvodeCounts counts_;
  SUNContext context_ = nullptr;
  N_Vector x_ = nullptr;
  void* cvode_ = nullptr;
  SUNNonlinearSolver corrector_ = nullptr;
};

}  // namespace

ExtendedCvodeCounts RunExtendedCvode(const ExtendedOscillator<double>& oscillator, double y0,
                                     std::span<const double> deflection, double clock, const SampleTimes& times,
                                     std::span<double> y) {
  return Run(oscillator, y0, deflection, clock).Go(times, y);
}

}  // namespace uiclink
