#include "vehicle/integrator.h"

#include <arkode/arkode_butcher_erk.h>
#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "vehicle/runge_kutta.h"
#include "vehicle/sundials_memory.h"
#include "vehicle/sundials_vector.h"
#include "vehicle/wagon_guards.h"

namespace uiclink {
namespace {

double* Data(N_Vector vector) { return N_VGetArrayPointer(vector); }

/// SUNDIALS' memory of a vector as a state: all vectors have kMaxState components.
StateVector<double>& AsState(N_Vector vector) { return *reinterpret_cast<StateVector<double>*>(Data(vector)); }

/// ARKODE's explicit pairs of order 3 and more.
struct ArkodeTable {
  std::string_view name;
  ARKODE_ERKTableID id;
  /// How far a step times an eigenvalue may go along the negative real and the imaginary axis, where it is used.
  double real_extent = 0, imaginary_extent = 0;
};
constexpr std::array<ArkodeTable, 7> kArkodeTables{
    {{"ARKODE_BOGACKI_SHAMPINE_4_2_3", ARKODE_BOGACKI_SHAMPINE_4_2_3},
     // Its solution of order 4 has four stages, as the classical method.
     {"ARKODE_ZONNEVELD_5_3_4", ARKODE_ZONNEVELD_5_3_4, kClassicalRealExtent, kClassicalImaginaryExtent},
     {"ARKODE_SAYFY_ABURUB_6_3_4", ARKODE_SAYFY_ABURUB_6_3_4},
     {"ARKODE_CASH_KARP_6_4_5", ARKODE_CASH_KARP_6_4_5},
     {"ARKODE_FEHLBERG_6_4_5", ARKODE_FEHLBERG_6_4_5},
     {"ARKODE_DORMAND_PRINCE_7_4_5", ARKODE_DORMAND_PRINCE_7_4_5},
     {"ARKODE_VERNER_8_5_6", ARKODE_VERNER_8_5_6}}};

const ArkodeTable* FindArkodeTable(std::string_view name) {
  // Not by ARKodeButcherTable_LoadERKByName(), which prints where a name is unknown.
  const auto known = std::ranges::find(kArkodeTables, name, &ArkodeTable::name);
  return known == kArkodeTables.end() ? nullptr : &*known;
}

/// A pair of ours or of ARKODE.
Owner<ARKodeButcherTable> MakeTable(const std::string& name) {
  const RungeKuttaPair* pair = FindRungeKuttaPair(name);
  if (pair == nullptr) {
    const ArkodeTable* known = FindArkodeTable(name);
    if (known == nullptr) throw std::invalid_argument("no explicit Runge-Kutta method has the name '" + name + "'");
    return Owner<ARKodeButcherTable>(ARKodeButcherTable_LoadERK(known->id));
  }
  const std::size_t s = pair->stages();
  std::vector<double> A(s * s), b(pair->rows.back()), c(s), d(pair->embedded);
  b.resize(s);
  for (std::size_t i = 1; i < s; ++i) {
    const std::vector<double>& row = pair->rows[i - 1];
    std::copy(row.begin(), row.end(), A.begin() + static_cast<std::ptrdiff_t>(i * s));
    c[i] = std::accumulate(row.begin(), row.end(), 0.0);
  }
  return Owner<ARKodeButcherTable>(ARKodeButcherTable_Create(static_cast<int>(s), pair->order, pair->embedded_order,
                                                             c.data(), A.data(), b.data(), d.data()));
}

/// First step after a start [s]: short against everything that moves. The step size that fits is found within few
/// steps.
constexpr double kFirstStep = 1e-4;

/// Relaxation times that turn scales of displacements into scales of rates [1/s].
constexpr double kWheelRate = 1000;  ///< creep and Hertz contact: 1.3e3 and 1.4e3 at 20 m/s
constexpr double kBodyRate = 10;     ///< the body on its springs

}  // namespace

StateVector<double> CalcErrorScales(const Wagon& wagon) {
  constexpr double displacement = 1e-3;  // [m], [rad]
  StateVector<double> scales;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    double* wheel = &scales[axle * wheelset::kSize];
    for (std::size_t i : {wheelset::kX, wheelset::kY, wheelset::kZ, wheelset::kPhi, wheelset::kPsi})
      wheel[i] = displacement;
    for (std::size_t i : {wheelset::kXRate, wheelset::kYRate, wheelset::kZRate, wheelset::kPhiRate, wheelset::kPsiRate,
                          wheelset::kBeta})
      wheel[i] = displacement * kWheelRate;
  }
  for (std::size_t i = 0; i < body::kSize; i += 2) {
    scales[kBody + i] = displacement;
    scales[kBody + i + 1] = displacement * kBodyRate;
  }
  for (std::size_t i = 0; i < kCorners; ++i) scales[kLeafForces + i] = displacement * std::max(wagon.leaf.c, 1.0);
  return scales;
}

double CalcStableStep(const Wagon& wagon, double V, double real_extent, double imaginary_extent) {
  if (real_extent == 0) return std::numeric_limits<double>::infinity();
  const ContactCurve::Place place = wagon.contact.Find(0.0);
  const WheelContact<double> c = ContactCurve::Evaluate(wagon.contact.cubic(place.cell), place.t);
  const WheelsetInertia& m = wagon.wheelset;
  double load = 0;
  for (const Wagon::Corner& corner : wagon.corners) load = std::max(load, corner.load);
  const double root = std::cbrt((load + 0.5 * m.m * wagon.g) / c.n);  // sqrt(q)
  const double creep = 2 * c.f11 * root * root * (1 / m.m + c.r * c.r / m.I_y) / V;
  const double bounce = std::sqrt(3 * c.n * root * std::max(1 / m.m, c.a * c.a / m.I_x));
  return std::min(real_extent / creep, imaginary_extent / bounce);
}

double FindTrackLimit(const ContactCurve& contact) {
  const double end = std::min(contact.y_max(), -contact.y_min());
  const auto sine = [&](double y) {
    const ContactCurve::Place place = contact.Find(y);
    const ContactCurve::Cubic* cubic = contact.after_jump(place.cell);
    if (cubic == nullptr) cubic = &contact.cubic(place.cell);
    return ContactCurve::Evaluate(*cubic, place.t).sin_delta;
  };
  double largest = 0;
  double limit = end;
  const int steps = static_cast<int>(end / contact.width());
  for (int i = 0; i <= steps; ++i) {
    const double y = static_cast<double>(i) * contact.width();
    const double s = sine(y);
    if (s < largest) continue;  // on the straight part of a flange the last place counts
    largest = s;
    limit = y;
  }
  // A tread without flange, or a table that ends before the steepest place: there is nothing to climb within it.
  constexpr double kFlange = 0.7;  // sin 45 degrees
  return largest > kFlange && limit + contact.width() < end ? limit : end;
}

// ---------------------------------------------------------------------------------------------------------------------

class Integrator::Impl {
 public:
  Impl(const Wagon& wagon, const IntegratorOptions& options)
      : wagon_(wagon), leaf_(wagon.options.suspension == Suspension::kLeaf), guards_(wagon) {
    if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
      throw std::invalid_argument("the tolerance of an integration must be positive");
    y_ = Owner<N_Vector>(NewStateVector(context_.get()));
    interpolated_ = Owner<N_Vector>(N_VClone(y_.get()));
    std::fill_n(Data(y_.get()), kMaxState, 0.0);
    Create(options);
  }

  void Start(double V, const WagonState& state) {
    if (!(V > 0) || !std::isfinite(V)) throw std::invalid_argument("the speed of the wagon must be positive");
    V_ = V;
    state_ = state;
    if (!leaf_) std::fill(state_.x.begin() + kLeafForces, state_.x.end(), 0.0);
    step_begin_ = state.t;
    step_links_ = state.links;
    AsState(y_.get()) = state_.x;
    AddCounts();
    Check(ERKStepReInit(arkode_.get(), &Rate, state.t, y_.get()));
    Check(ERKStepSetInitStep(arkode_.get(), kFirstStep));
    const double stable = CalcStableStep(wagon_, V, real_extent_, imaginary_extent_);
    Check(ERKStepSetMaxStep(arkode_.get(), std::min(max_step_, stable)));
    pending_ = false;
    have_forces_ = false;
    stage_time_ = std::numeric_limits<double>::quiet_NaN();
    derailed_ = false;
    message_.clear();
    // A state on an event, or one put together by hand, may be beyond the end of its mode.
    AsState(y_.get()) = state_.x;
    guards_.Start(V, &state_);
    step_links_ = state_.links;
  }

  Advance Step(double t_stop) {
    if (derailed_) return Advance::kDerailed;
    if (t_stop <= state_.t) return Advance::kStopTime;
    if (pending_) Restart();
    Check(ERKStepSetStopTime(arkode_.get(), t_stop));
    step_begin_ = state_.t;
    double t = state_.t;
    const int flag = ERKStepEvolve(arkode_.get(), t_stop, y_.get(), &t, ARK_ONE_STEP);
    Check(flag);
    state_.t = t;
    state_.x = AsState(y_.get());
    have_forces_ = false;
    guards_.FollowLeaves(state_.x);
    if (flag == ARK_ROOT_RETURN) return PassEvent();
    if (first_same_as_last_ || stage_time_ == t) {  // the last right-hand side was at the end of the step
      std::swap(current_, stage_);
      have_forces_ = true;
    }
    return flag == ARK_TSTOP_RETURN ? Advance::kStopTime : Advance::kStep;
  }

  void Interpolate(double t, StateVector<double>* x) {
    if (t == state_.t) {
      *x = state_.x;
      return;
    }
    Check(ERKStepGetDky(arkode_.get(), t, 0, interpolated_.get()));
    *x = AsState(interpolated_.get());
  }

  const WagonState& state() const { return state_; }
  double step_begin() const { return step_begin_; }
  const LinkStates& step_links() const { return step_links_; }
  const StateVector<double>& rate() {
    CalcRate(wagon_, V_, state_.links, state_.x, &rate_);
    return rate_;
  }
  const WagonForces& forces() {
    EvaluateForces();
    return *current_;
  }
  const IntegratorCounts& counts() {
    total_ = before_;
    long steps = 0, calls = 0, failed = 0;
    ERKStepGetNumSteps(arkode_.get(), &steps);
    ERKStepGetNumRhsEvals(arkode_.get(), &calls);
    ERKStepGetNumErrTestFails(arkode_.get(), &failed);
    total_.steps += steps;
    total_.rhs_calls += calls;
    total_.failed_steps += failed;
    return total_;
  }
  double V() const { return V_; }
  const Wagon& wagon() const { return wagon_; }

 private:
  static Impl& Self(void* self) { return *static_cast<Impl*>(self); }

  void Create(const IntegratorOptions& options) {
    const std::string method = options.method.empty() ? std::string(kDefaultMethod) : options.method;
    table_ = MakeTable(method);
    if (const RungeKuttaPair* pair = FindRungeKuttaPair(method)) {
      first_same_as_last_ = true;
      real_extent_ = pair->real_extent;
      imaginary_extent_ = pair->imaginary_extent;
    } else if (const ArkodeTable* table = FindArkodeTable(method)) {
      real_extent_ = table->real_extent;
      imaginary_extent_ = table->imaginary_extent;
    }
    max_step_ = options.max_step;
    arkode_.reset(ERKStepCreate(&Rate, 0, y_.get(), context_.get()));
    if (!arkode_) throw std::runtime_error("Integrator: ERKStepCreate failed");
    Check(ERKStepSetErrHandlerFn(arkode_.get(), &KeepMessage, this));
    Check(ERKStepSetUserData(arkode_.get(), this));
    Check(ERKStepSetTable(arkode_.get(), table_.get()));
    weights_ = CalcErrorScales(wagon_);
    for (double& w : weights_) w = 1 / (w * options.tolerance);
    Check(ERKStepWFtolerances(arkode_.get(), &Weights));
    // The cubic of Hermite needs no further right-hand sides.
    Check(ERKStepSetInterpolantType(arkode_.get(), ARK_INTERP_HERMITE));
    Check(ERKStepSetInterpolantDegree(arkode_.get(), 3));
    Check(ERKStepSetMaxNumSteps(arkode_.get(), -1));
    Check(ERKStepRootInit(arkode_.get(), static_cast<int>(guards_.size()), &Guards));
    Check(ERKStepSetNoInactiveRootWarn(arkode_.get()));
    std::array<int, WagonGuards::kMost> direction{};
    for (std::size_t i = 0; i < guards_.size(); ++i) direction[i] = WagonGuards::IsFalling(guards_[i].kind) ? -1 : 0;
    Check(ERKStepSetRootDirection(arkode_.get(), direction.data()));
  }

  Advance PassEvent() {
    std::array<int, WagonGuards::kMost> crossed{};
    Check(ERKStepGetRootInfo(arkode_.get(), crossed.data()));
    step_links_ = state_.links;
    for (std::size_t i = 0; i < guards_.size(); ++i) {
      if (crossed[i] == 0) continue;
      if (guards_[i].kind == WagonGuards::Kind::kLinks) guards_.Settle(&state_);
      if (guards_[i].kind == WagonGuards::Kind::kTrack) derailed_ = true;
      // Guidance and springs know themselves on which side they are, or which way they go; the step had to end here.
    }
    ++before_.events;
    pending_ = true;
    have_forces_ = false;
    return derailed_ ? Advance::kDerailed : Advance::kEvent;
  }

  /// Goes on behind an event: the right-hand side is the same on both sides of it, so the step size is good.
  void Restart() {
    pending_ = false;
    step_links_ = state_.links;
    double next = 0;
    Check(ERKStepGetCurrentStep(arkode_.get(), &next));
    Check(ERKStepReset(arkode_.get(), state_.t, y_.get()));
    Check(ERKStepSetInitStep(arkode_.get(), next));
  }

  void EvaluateForces() {
    if (have_forces_) return;
    CalcForces(wagon_, V_, state_.links, state_.x, &rate_, current_);
    have_forces_ = true;
  }

  void AddCounts() { before_ = counts(); }

  void Check(int flag) const {
    if (flag >= 0) return;
    throw std::runtime_error("the integration stopped at " + std::to_string(state_.t) +
                             " s: " + (message_.empty() ? std::string("out of memory") : message_));
  }

  static int Rate(realtype t, N_Vector x, N_Vector rate, void* self) {
    Impl& me = Self(self);
    // ARKODE keeps the rate at the begin of a step, and so that at its end, where it has put the very first one.
    if (me.first_rate_ == nullptr) me.first_rate_ = rate;
    if (me.first_same_as_last_ || rate == me.first_rate_) {
      CalcForces(me.wagon_, me.V_, me.state_.links, AsState(x), &AsState(rate), me.stage_);
      me.stage_time_ = t;
    } else {
      CalcRate(me.wagon_, me.V_, me.state_.links, AsState(x), &AsState(rate));
    }
    return 0;
  }

  static int Weights(N_Vector, N_Vector weights, void* self) {
    AsState(weights) = Self(self).weights_;
    return 0;
  }

  static int Guards(realtype, N_Vector vector, realtype* values, void* self) {
    const Impl& me = Self(self);
    me.guards_.Calc(me.state_.links, AsState(vector), values);
    return 0;
  }

  static void KeepMessage(int, const char*, const char*, char* message, void* self) { Self(self).message_ = message; }

  const Wagon& wagon_;
  const bool leaf_;
  WagonGuards guards_;
  double V_ = 0;

  Owner<SUNContext> context_ = MakeSundialsContext();
  Owner<N_Vector> y_, interpolated_;
  Owner<ARKodeButcherTable> table_;
  Owner<void*> arkode_;
  double real_extent_ = 0, imaginary_extent_ = 0;  ///< of the method's stability; 0: not known
  double max_step_ = 0;

  WagonState state_;
  LinkStates step_links_;
  double step_begin_ = 0;
  bool pending_ = false;  ///< an event has been passed, ARKODE does not know yet: its interpolant is still wanted
  bool derailed_ = false;
  bool have_forces_ = false;
  bool first_same_as_last_ = false;
  StateVector<double> weights_{};  ///< of errors: 1 / tolerance
  StateVector<double> rate_{};
  std::array<WagonForces, 2> forces_;
  WagonForces* current_ = &forces_[0];  ///< at the end of the last step
  WagonForces* stage_ = &forces_[1];    ///< of the stage that was computed last with forces ...
  double stage_time_ = 0;               ///< ... and its time
  const void* first_rate_ = nullptr;    ///< vector of the stage at the begin of a step
  IntegratorCounts before_, total_;
  std::string message_;
};

Integrator::Integrator(const Wagon& wagon, const IntegratorOptions& options)
    : impl_(std::make_unique<Impl>(wagon, options)) {}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;
Integrator& Integrator::operator=(Integrator&&) noexcept = default;

void Integrator::Start(double V, const WagonState& state) { impl_->Start(V, state); }
Advance Integrator::Step(double t_stop) { return impl_->Step(t_stop); }
const WagonState& Integrator::state() const { return impl_->state(); }
double Integrator::step_begin() const { return impl_->step_begin(); }
const LinkStates& Integrator::step_links() const { return impl_->step_links(); }
void Integrator::Interpolate(double t, StateVector<double>* x) const { impl_->Interpolate(t, x); }
WheelLoads Integrator::loads() const { return LoadsOf(forces()); }
void Integrator::Restart(const WagonState& state) { Start(speed(), state); }
const StateVector<double>& Integrator::rate() const { return impl_->rate(); }
const WagonForces& Integrator::forces() const { return impl_->forces(); }
const IntegratorCounts& Integrator::counts() const { return impl_->counts(); }
double Integrator::speed() const { return impl_->V(); }
const Wagon& Integrator::wagon() const { return impl_->wagon(); }

}  // namespace uiclink
