#include "tests/support/cvode_reference.h"

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace uiclink {
namespace {

void Check(int flag, const char* what) {
  if (flag < 0) throw std::runtime_error(std::string("CvodeReference: ") + what + " returned " + std::to_string(flag));
}

/// What SUNDIALS makes, with the function that frees it.
struct Free {
  void operator()(SUNContext context) const { SUNContext_Free(&context); }
  void operator()(N_Vector vector) const { N_VDestroy(vector); }
  void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
  void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
  void operator()(SUNNonlinearSolver solver) const { SUNNonlinSolFree(solver); }
  void operator()(void* cvode) const { CVodeFree(&cvode); }
};
template <typename Handle>
using Owner = std::unique_ptr<std::remove_pointer_t<Handle>, Free>;
using Context = Owner<SUNContext>;
using Vector = Owner<N_Vector>;

Context MakeContext() {
  SUNContext context = nullptr;
  Check(SUNContext_Create(nullptr, &context), "SUNContext_Create");
  return Context(context);
}

double* Data(N_Vector x) { return N_VGetArrayPointer(x); }

}  // namespace

/// CVODES with its memory, and the mode of the sliders.  State vector: y, v, T_1 .. T_n.
class CvodeReference::Integrator {
 public:
  Integrator(int sliders, int derivatives, const CvodeOptions& options)
      : options_(options), n_(static_cast<std::size_t>(sliders)), derivatives_(derivatives) {
    x_ = NewVector();
    before_.resize(n_ + 2);
    after_.resize(n_ + 2);
    sliding_.resize(n_);
    roots_.resize(n_ + 1);
    cvode_.reset(CVodeCreate(options.method == CvodeOptions::Method::kAdams ? CV_ADAMS : CV_BDF, context_.get()));
    Check(CVodeInit(cvode_.get(), &Rhs, 0, x_.get()), "CVodeInit");
    Check(CVodeSStolerances(cvode_.get(), options.rtol, options.atol), "CVodeSStolerances");
    Check(CVodeSetUserData(cvode_.get(), this), "CVodeSetUserData");
    Check(CVodeSetMaxNumSteps(cvode_.get(), -1), "CVodeSetMaxNumSteps");
    Check(CVodeRootInit(cvode_.get(), sliders + 1, &Guards), "CVodeRootInit");
    Check(CVodeSetNoInactiveRootWarn(cvode_.get()), "CVodeSetNoInactiveRootWarn");
    MakeCorrector();
    if (derivatives_ > 0) InitSensitivities();
  }

  CvodeCounts Run(const Oscillator<double>& oscillator, const State<double>& start, std::span<const Seed> seeds,
                  const SampleTimes& times, std::span<double> y, std::span<double> dy) {
    oscillator_ = &oscillator;
    seeds_ = seeds;
    counts_ = {};
    Start(start);
    double t = 0;
    std::size_t next = 0;
    for (; next < times.size && times[next] <= 0; ++next) {
      y[next] = Data(x_.get())[0];
      for (std::size_t p = 0; p < seeds.size(); ++p) dy[p * times.size + next] = Data(s_[p])[0];
    }
    Restart(0);
    while (next < times.size) {
      const int flag = CVode(cvode_.get(), times[times.size - 1], x_.get(), &t, CV_ONE_STEP);
      Check(flag, "CVode");
      for (; next < times.size && times[next] <= t; ++next) Sample(times, next, y, dy);
      if (flag == CV_ROOT_RETURN) PassEvent(t);
    }
    AddCounts();
    return counts_;
  }

 private:
  static Integrator& Self(void* self) { return *static_cast<Integrator*>(self); }
  double k(std::size_t i) const { return oscillator_->sliders()[i].k; }
  double T0(std::size_t i) const { return oscillator_->sliders()[i].T0; }
  Vector NewVector() const {
    Vector vector(N_VNew_Serial(static_cast<sunindextype>(n_ + 2), context_.get()));
    N_VEnableFusedOps_Serial(vector.get(), SUNTRUE);  // up to a seventh faster with ten derivatives
    return vector;
  }

  void MakeCorrector() {
    if (options_.corrector == CvodeOptions::Corrector::kFixedPoint) {
      corrector_.reset(SUNNonlinSol_FixedPoint(x_.get(), 0, context_.get()));
      Check(CVodeSetNonlinearSolver(cvode_.get(), corrector_.get()), "CVodeSetNonlinearSolver");
      return;
    }
    const auto size = static_cast<sunindextype>(n_ + 2);
    matrix_.reset(SUNDenseMatrix(size, size, context_.get()));
    linear_.reset(SUNLinSol_Dense(x_.get(), matrix_.get(), context_.get()));
    Check(CVodeSetLinearSolver(cvode_.get(), linear_.get(), matrix_.get()), "CVodeSetLinearSolver");
    Check(CVodeSetJacFn(cvode_.get(), &Jacobian), "CVodeSetJacFn");
  }

  void InitSensitivities() {
    for (int p = 0; p < derivatives_; ++p) {
      s_memory_.push_back(NewVector());
      s_.push_back(s_memory_.back().get());
      N_VConst(0, s_.back());
    }
    const bool simultaneous = options_.sensitivities == CvodeOptions::Sensitivities::kSimultaneous;
    sensitivity_method_ = simultaneous ? CV_SIMULTANEOUS : CV_STAGGERED;
    Check(CVodeSensInit(cvode_.get(), derivatives_, sensitivity_method_, &SensitivityRhs, s_.data()), "CVodeSensInit");
    std::vector<double> tolerances;
    for (std::size_t p = 0; p < s_.size(); ++p)
      tolerances.push_back(options_.atol / (p < options_.parameter_scale.size() ? options_.parameter_scale[p] : 1.0));
    Check(CVodeSensSStolerances(cvode_.get(), options_.rtol, tolerances.data()), "CVodeSensSStolerances");
    Check(CVodeSetSensErrCon(cvode_.get(), options_.control_derivatives), "CVodeSetSensErrCon");
    if (options_.corrector == CvodeOptions::Corrector::kNewton) return;  // CVODES makes that one itself
    if (simultaneous) {
      sensitivity_corrector_.reset(SUNNonlinSol_FixedPointSens(derivatives_ + 1, x_.get(), 0, context_.get()));
      Check(CVodeSetNonlinearSolverSensSim(cvode_.get(), sensitivity_corrector_.get()), "SetNonlinearSolverSensSim");
    } else {
      sensitivity_corrector_.reset(SUNNonlinSol_FixedPointSens(derivatives_, x_.get(), 0, context_.get()));
      Check(CVodeSetNonlinearSolverSensStg(cvode_.get(), sensitivity_corrector_.get()), "SetNonlinearSolverSensStg");
    }
  }

  void Start(const State<double>& start) {
    double* x = Data(x_.get());
    x[0] = start.y;
    x[1] = start.v;
    std::copy_n(start.T.begin(), n_, x + 2);
    for (std::size_t p = 0; p < seeds_.size(); ++p) {
      Data(s_[p])[0] = seeds_[p].start.y;
      Data(s_[p])[1] = seeds_[p].start.v;
      std::copy_n(seeds_[p].start.T.begin(), n_, Data(s_[p]) + 2);
    }
    std::fill(sliding_.begin(), sliding_.end(), false);
    travel_ = 1;
    Evaluate(x, before_.data());
    const double heading = x[1] != 0 ? x[1] : before_[1];  // from rest it goes where the force points
    travel_ = heading < 0 ? -1 : 1;
    SlideAtLimit();
  }

  /// Sliders that stand at the limit that the coming half swing drives them against slide from its first moment.
  void SlideAtLimit() {
    for (std::size_t i = 0; i < n_; ++i)
      if (!sliding_[i] && T0(i) + travel_ * Data(x_.get())[2 + i] <= 0) BreakOut(i);
  }

  void BreakOut(std::size_t i) {
    double* x = Data(x_.get());
    Evaluate(x, before_.data());
    sliding_[i] = true;
    Evaluate(x, after_.data());
    const double rate = travel_ * before_[2 + i];
    Jump(rate, [&](std::size_t p) { return seeds_[p].oscillator.sliders()[i].T0 + travel_ * Data(s_[p])[2 + i]; });
    x[2 + i] = -travel_ * T0(i);
    // At rest the formula reads 0/0; that the force stays at its limit holds there, too.
    if (rate == 0)
      for (std::size_t p = 0; p < seeds_.size(); ++p)
        Data(s_[p])[2 + i] = -travel_ * seeds_[p].oscillator.sliders()[i].T0;
  }

  /// s+ = s- + (f- - f+) dt*/dp for the guard of the given rate g_x f- and derivative g_p + g_x s-.
  template <typename Guard>
  void Jump(double rate, Guard guard) {
    if (rate == 0) return;
    for (std::size_t p = 0; p < seeds_.size(); ++p) {
      const double event_time = -guard(p) / rate;
      for (std::size_t j = 0; j < n_ + 2; ++j) Data(s_[p])[j] += (before_[j] - after_[j]) * event_time;
    }
  }

  void Turn() {
    Evaluate(Data(x_.get()), before_.data());
    std::fill(sliding_.begin(), sliding_.end(), false);
    Evaluate(Data(x_.get()), after_.data());
    Jump(before_[1], [&](std::size_t p) { return Data(s_[p])[1]; });
    travel_ = -travel_;
  }

  void PassEvent(double t) {
    Check(CVodeGetRootInfo(cvode_.get(), roots_.data()), "CVodeGetRootInfo");
    if (derivatives_ > 0) Check(CVodeGetSens(cvode_.get(), &t, s_.data()), "CVodeGetSens");
    bool restart = std::find(sliding_.begin(), sliding_.end(), true) != sliding_.end();
    for (std::size_t i = 0; i < n_; ++i) {
      if (roots_[1 + i] == 0 || sliding_[i]) continue;
      BreakOut(i);
      ++counts_.breakouts;
      restart = true;
    }
    if (roots_[0] != 0) {
      Turn();
      ++counts_.turnings;
      SlideAtLimit();
    }
    if (restart) Restart(t);  // a turning point at which nothing had been sliding is smooth
  }

  void Restart(double t) {
    AddCounts();
    Check(CVodeReInit(cvode_.get(), t, x_.get()), "CVodeReInit");
    if (derivatives_ > 0) Check(CVodeSensReInit(cvode_.get(), sensitivity_method_, s_.data()), "CVodeSensReInit");
  }

  void AddCounts() {
    long steps = 0, calls = 0;
    CVodeGetNumSteps(cvode_.get(), &steps);
    CVodeGetNumRhsEvals(cvode_.get(), &calls);
    counts_.steps += steps;
    counts_.rhs_calls += calls;
  }

  void Sample(const SampleTimes& times, std::size_t i, std::span<double> y, std::span<double> dy) {
    if (!sample_) sample_ = NewVector();
    Check(CVodeGetDky(cvode_.get(), times[i], 0, sample_.get()), "CVodeGetDky");
    y[i] = Data(sample_.get())[0];
    for (std::size_t p = 0; p < seeds_.size(); ++p) {
      Check(CVodeGetSensDky1(cvode_.get(), times[i], 0, static_cast<int>(p), sample_.get()), "CVodeGetSensDky1");
      dy[p * times.size + i] = Data(sample_.get())[0];
    }
  }

  /// f(x) in the present mode.
  void Evaluate(const double* x, double* f) const {
    double force = -oscillator_->k * x[0];
    for (std::size_t i = 0; i < n_; ++i) {
      force += x[2 + i];
      f[2 + i] = sliding_[i] ? 0 : -k(i) * x[1];
    }
    f[0] = x[1];
    f[1] = oscillator_->g * force;
  }

  static int Rhs(realtype, N_Vector x, N_Vector f, void* self) {
    Self(self).Evaluate(Data(x), Data(f));
    return 0;
  }

  static int Guards(realtype, N_Vector x, realtype* guards, void* self) {
    const Integrator& it = Self(self);
    guards[0] = Data(x)[1];
    for (std::size_t i = 0; i < it.n_; ++i) guards[1 + i] = it.sliding_[i] ? 1 : it.T0(i) + it.travel_ * Data(x)[2 + i];
    return 0;
  }

  static int Jacobian(realtype, N_Vector, N_Vector, SUNMatrix matrix, void* self, N_Vector, N_Vector, N_Vector) {
    const Integrator& it = Self(self);
    SUNMatZero(matrix);
    SM_ELEMENT_D(matrix, 0, 1) = 1;
    SM_ELEMENT_D(matrix, 1, 0) = -it.oscillator_->g * it.oscillator_->k;
    for (std::size_t i = 0; i < it.n_; ++i) {
      SM_ELEMENT_D(matrix, 1, 2 + i) = it.oscillator_->g;
      if (!it.sliding_[i]) SM_ELEMENT_D(matrix, 2 + i, 1) = -it.k(i);
    }
    return 0;
  }

  static int SensitivityRhs(int, realtype, N_Vector state, N_Vector, N_Vector* s, N_Vector* s_dot, void* self, N_Vector,
                            N_Vector) {
    const Integrator& it = Self(self);
    const double* x = Data(state);
    for (std::size_t p = 0; p < it.seeds_.size(); ++p) {
      const Oscillator<double>& seed = it.seeds_[p].oscillator;
      it.Evaluate(Data(s[p]), Data(s_dot[p]));
      Data(s_dot[p])[1] -= it.oscillator_->g * seed.k * x[0];
      for (std::size_t i = 0; i < it.n_; ++i)
        if (!it.sliding_[i]) Data(s_dot[p])[2 + i] -= seed.sliders()[i].k * x[1];
    }
    return 0;
  }

  CvodeOptions options_;
  std::size_t n_;
  int derivatives_;
  int sensitivity_method_ = CV_SIMULTANEOUS;

  // In the order of their making: each is freed before what it was made with.
  Context context_ = MakeContext();
  Vector x_, sample_;
  std::vector<Vector> s_memory_;
  std::vector<N_Vector> s_;
  Owner<SUNMatrix> matrix_;
  Owner<SUNLinearSolver> linear_;
  Owner<SUNNonlinearSolver> corrector_, sensitivity_corrector_;
  Owner<void*> cvode_;

  const Oscillator<double>* oscillator_ = nullptr;
  std::span<const Seed> seeds_;
  double travel_ = 1;  // sign of the velocity of the present half swing
  std::vector<char> sliding_;
  std::vector<int> roots_;
  std::vector<double> before_, after_;  // the field on both sides of an event
  CvodeCounts counts_;
};

CvodeReference::CvodeReference(int sliders, int derivatives, const CvodeOptions& options)
    : integrator_(std::make_unique<Integrator>(sliders, derivatives, options)) {}

CvodeReference::~CvodeReference() = default;

CvodeCounts CvodeReference::RunSeeded(const Oscillator<double>& oscillator, const State<double>& start,
                                      std::span<const Seed> seeds, const SampleTimes& times, std::span<double> y,
                                      std::span<double> dy) {
  return integrator_->Run(oscillator, start, seeds, times, y, dy);
}

}  // namespace uiclink
