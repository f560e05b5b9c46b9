#include "tests/support/wagon_implicit.h"

#include <cvodes/cvodes.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "vehicle/integrator.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

struct Free {
  void operator()(SUNContext context) const { SUNContext_Free(&context); }
  void operator()(N_Vector vector) const { N_VDestroy(vector); }
  void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
  void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
  void operator()(void* cvode) const { CVodeFree(&cvode); }
};
template <typename Handle>
using Owner = std::unique_ptr<std::remove_pointer_t<Handle>, Free>;

void Check(int flag) {
  if (flag < 0) throw std::runtime_error("RunImplicit: CVODE returned " + std::to_string(flag));
}

StateVector<double> Read(N_Vector x) {
  StateVector<double> state{};
  for (sunindextype i = 0; i < NV_LENGTH_S(x); ++i) state[static_cast<std::size_t>(i)] = NV_Ith_S(x, i);
  return state;
}

struct Model {
  const Wagon& wagon;
  double V;
  LinkStates links;
};

int Rate(realtype, N_Vector x, N_Vector out, void* self) {
  const Model& model = *static_cast<const Model*>(self);
  StateVector<double> rate;
  CalcRate(model.wagon, model.V, model.links, Read(x), &rate);
  for (sunindextype i = 0; i < NV_LENGTH_S(out); ++i) NV_Ith_S(out, i) = rate[static_cast<std::size_t>(i)];
  return 0;
}

int Jacobian(realtype, N_Vector x, N_Vector, SUNMatrix J, void* self, N_Vector, N_Vector, N_Vector) {
  using T = Dual<static_cast<int>(kMaxState)>;
  const Model& model = *static_cast<const Model*>(self);
  const StateVector<double> at = Read(x);
  StateVector<T> dual, rate;
  for (std::size_t i = 0; i < kMaxState; ++i) dual[i] = T(at[i], static_cast<int>(i));
  CalcRate(model.wagon, model.V, model.links, dual, &rate);
  const sunindextype n = SM_ROWS_D(J);
  for (sunindextype c = 0; c < n; ++c)
    for (sunindextype r = 0; r < n; ++r) SM_ELEMENT_D(J, r, c) = rate[static_cast<std::size_t>(r)].v[c];
  return 0;
}

int Margins(realtype, N_Vector x, realtype* margins, void* self) {
  const Model& model = *static_cast<const Model*>(self);
  const StateVector<double> at = Read(x);
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerDeflection<double> d = CalcDeflection(model.wagon, at, i);
    margins[i] = model.links.longitudinal[i].CalcMargin(model.wagon.longitudinal[i], d.dx, d.vx, 0);
    margins[kCorners + i] = model.links.lateral[i].CalcMargin(model.wagon.lateral[i], d.dy, d.vy, 0);
  }
  return 0;
}

}  // namespace

WagonState RunImplicit(const Wagon& wagon, double V, const WagonState& start, double t_end,
                       const ImplicitOptions& options, ImplicitCounts* counts) {
  Model model{wagon, V, start.links};
  SUNContext context_handle = nullptr;
  Check(SUNContext_Create(nullptr, &context_handle));
  const Owner<SUNContext> context(context_handle);
  const auto n = static_cast<sunindextype>(wagon.size());
  const Owner<N_Vector> x(N_VNew_Serial(n, context.get())), atol(N_VNew_Serial(n, context.get()));
  const StateVector<double> scales = CalcErrorScales(wagon);
  for (sunindextype i = 0; i < n; ++i) {
    NV_Ith_S(x.get(), i) = start.x[static_cast<std::size_t>(i)];
    NV_Ith_S(atol.get(), i) = options.atol * scales[static_cast<std::size_t>(i)] / 1e-3;
  }
  const Owner<void*> cvode(CVodeCreate(CV_BDF, context.get()));
  Check(CVodeInit(cvode.get(), &Rate, start.t, x.get()));
  Check(CVodeSVtolerances(cvode.get(), options.rtol, atol.get()));
  Check(CVodeSetUserData(cvode.get(), &model));
  Check(CVodeSetMaxNumSteps(cvode.get(), -1));
  const Owner<SUNMatrix> matrix(SUNDenseMatrix(n, n, context.get()));
  const Owner<SUNLinearSolver> solver(SUNLinSol_Dense(x.get(), matrix.get(), context.get()));
  Check(CVodeSetLinearSolver(cvode.get(), solver.get(), matrix.get()));
  if (options.jacobian == JacobianKind::kExact) Check(CVodeSetJacFn(cvode.get(), &Jacobian));
  constexpr int kMargins = 2 * kCorners;
  Check(CVodeRootInit(cvode.get(), kMargins, &Margins));
  std::array<int, kMargins> falling;
  falling.fill(-1);
  Check(CVodeSetRootDirection(cvode.get(), falling.data()));
  Check(CVodeSetNoInactiveRootWarn(cvode.get()));
  Check(CVodeSetStopTime(cvode.get(), t_end));

  ImplicitCounts total;
  const auto add = [&] {
    long steps = 0, calls = 0, differences = 0, jacobians = 0;
    CVodeGetNumSteps(cvode.get(), &steps);
    CVodeGetNumRhsEvals(cvode.get(), &calls);
    CVodeGetNumLinRhsEvals(cvode.get(), &differences);
    CVodeGetNumJacEvals(cvode.get(), &jacobians);
    total.steps += steps;
    total.rhs_calls += calls + differences;
    total.jacobians += jacobians;
  };
  double t = start.t;
  while (t < t_end) {
    const int flag = CVode(cvode.get(), t_end, x.get(), &t, CV_NORMAL);
    Check(flag);
    if (flag != CV_ROOT_RETURN) break;
    ++total.events;
    const StateVector<double> at = Read(x.get());
    std::array<int, kMargins> crossed{};
    Check(CVodeGetRootInfo(cvode.get(), crossed.data()));
    for (std::size_t i = 0; i < kCorners; ++i) {
      const CornerDeflection<double> d = CalcDeflection(wagon, at, i);
      if (crossed[i] != 0) model.links.longitudinal[i].Switch(wagon.longitudinal[i], d.dx, d.vx, 0);
      if (crossed[kCorners + i] != 0) model.links.lateral[i].Switch(wagon.lateral[i], d.dy, d.vy, 0);
    }
    add();
    double step = 0;
    Check(CVodeGetLastStep(cvode.get(), &step));
    Check(CVodeReInit(cvode.get(), t, x.get()));
    Check(CVodeSetStopTime(cvode.get(), t_end));
  }
  add();
  if (counts != nullptr) *counts = total;
  return {.t = t_end, .x = Read(x.get()), .links = model.links};
}

}  // namespace uiclink
