#include "vehicle/equilibrium.h"

#include <Eigen/Dense>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

using Jacobian = Dual<static_cast<int>(kMaxState)>;

/// Newton's method stops once a step changes no displacement by more than this [m], [rad], [rad/s]; it has then
/// converged to rounding, because the step before was of the order of its root.
constexpr double kSmallStep = 1e-11;
constexpr int kMostIterations = 50;

/// Accelerations that are left are rounding of forces: 1e5 N on 1e3 kg to sixteen digits is 1e-14; Hertz contact
/// turns a rounding of heights (1e-19 m of 1e-3 m) into 1e-13 m/s^2.
constexpr double kLargestResidual = 1e-7;

/// The links with every joint relaxed wherever the link stands, so that the main springs alone pull: what a stuck
/// joint adds to K is taken out again.
LinkState CalcRelaxed(const Link& link, double d) {
  LinkState state = LinkState::AtRest(link, d);
  const double force = state.C - state.K * d;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    const bool in_clearance = link.law().has_gap && link.sliders()[i].joint;
    if (!in_clearance) state.K -= link.load() * link.sliders()[i].k;
  }
  state.C = force + state.K * d;
  return state;
}

LinkStates CalcLinks(const Wagon& wagon, const StateVector<double>& x, LinkState (*make)(const Link&, double)) {
  LinkStates links;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerDeflection<double> d = CalcDeflection(wagon, x, i);
    links.longitudinal[i] = make(wagon.longitudinal[i], d.dx);
    links.lateral[i] = make(wagon.lateral[i], d.dy);
  }
  return links;
}

/// The unknowns as places in the state vector, and the rates that vanish with them. With leaf springs two more: a
/// change of all leaf forces, and one between left and right, while compressions keep their mean and their difference.
class Problem {
 public:
  Problem(const Wagon& wagon, double V) : wagon_(wagon), V_(V), leaf_(wagon.options.suspension == Suspension::kLeaf) {
    for (std::size_t axle = 0; axle < kAxles; ++axle) {
      const std::size_t w = axle * wheelset::kSize;
      for (std::size_t i : {wheelset::kX, wheelset::kY, wheelset::kZ, wheelset::kPhi, wheelset::kPsi})
        Add(w + i, w + i + 1);
      Add(w + wheelset::kBeta, w + wheelset::kBeta);
    }
    for (std::size_t i : {body::kY, body::kZ, body::kPhi, body::kPsi}) Add(kBody + i, kBody + i + 1);
  }

  std::size_t size() const { return places_.size() + (leaf_ ? 2 : 0); }

  StateVector<double> MakeStart() const {
    StateVector<double> x{};
    const ContactCurve::Place place = wagon_.contact.Find(0.0);
    const WheelContact<double> contact = ContactCurve::Evaluate(wagon_.contact.cubic(place.cell), place.t);
    const double wheel = (0.25 * wagon_.body.m + 0.5 * wagon_.wheelset.m) * wagon_.g;
    const double z =
        ContactCurve::Evaluate(wagon_.contact.pose_cubic(place.cell), place.t).z - std::pow(wheel / contact.n, 2.0 / 3);
    for (std::size_t axle = 0; axle < kAxles; ++axle) {
      x[axle * wheelset::kSize + wheelset::kZ] = z;
      x[axle * wheelset::kSize + wheelset::kBeta] = V_ / contact.r - V_ / wagon_.r0;
    }
    x[kBody + body::kZ] = z;
    if (leaf_)
      for (std::size_t i = 0; i < kCorners; ++i) x[kLeafForces + i] = wagon_.corners[i].load;
    return x;
  }

  /// Residuals and their derivatives at x.
  void Evaluate(const StateVector<double>& x, Eigen::VectorXd* residual, Eigen::MatrixXd* jacobian) {
    for (std::size_t i = 0; i < kMaxState; ++i) x_[i] = Jacobian(x[i], static_cast<int>(i));
    CalcRate(wagon_, V_, CalcLinks(wagon_, x, &CalcRelaxed), x_, &rate_);
    const auto row = [&](Eigen::Index r, const Jacobian& value) {
      (*residual)(r) = value.a;
      for (std::size_t c = 0; c < places_.size(); ++c)
        (*jacobian)(r, static_cast<Eigen::Index>(c)) = value.v[static_cast<Eigen::Index>(places_[c])];
      if (!leaf_) return;
      double all = 0, between = 0;
      for (std::size_t i = 0; i < kCorners; ++i) {
        const double by_force = value.v[static_cast<Eigen::Index>(kLeafForces + i)];
        all += by_force;
        between += SideOf(i) * by_force;
      }
      (*jacobian)(r, static_cast<Eigen::Index>(places_.size())) = all;
      (*jacobian)(r, static_cast<Eigen::Index>(places_.size() + 1)) = between;
    };
    Eigen::Index r = 0;
    for (std::size_t i : rates_) row(r++, rate_[i]);
    if (!leaf_) return;
    Jacobian mean(0.0), difference(0.0);
    for (std::size_t i = 0; i < kCorners; ++i) {
      const Jacobian s = CalcDeflection(wagon_, x_, i).s - wagon_.corners[i].s_eq;
      mean += 0.25 * s;
      difference += 0.25 * SideOf(i) * s;
    }
    row(r++, mean);
    row(r++, difference);
  }

  void Move(const Eigen::VectorXd& step, StateVector<double>* x) const {
    for (std::size_t i = 0; i < places_.size(); ++i) (*x)[places_[i]] -= step(static_cast<Eigen::Index>(i));
    if (!leaf_) return;
    const auto n = static_cast<Eigen::Index>(places_.size());
    for (std::size_t i = 0; i < kCorners; ++i) (*x)[kLeafForces + i] -= step(n) + SideOf(i) * step(n + 1);
  }

  /// A step of Newton's method, as far as displacements go.
  double SizeOf(const Eigen::VectorXd& step) const {
    return step.head(static_cast<Eigen::Index>(places_.size())).cwiseAbs().maxCoeff();
  }

 private:
  void Add(std::size_t place, std::size_t rate) {
    places_.push_back(place);
    rates_.push_back(rate);
  }

  const Wagon& wagon_;
  double V_;
  bool leaf_;
  std::vector<std::size_t> places_, rates_;
  StateVector<Jacobian> x_, rate_;
};

/// A step is cut where it would lift a wheel or leave the table: 1 mm and 1 mrad are much for an equilibrium.
double CalcShare(double size) { return size > 1e-3 ? 1e-3 / size : 1.0; }

std::string Format(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

void CheckOnTrack(const Wagon& wagon, double V, const WagonState& state) {
  StateVector<double> rate;
  WagonForces forces;
  CalcForces(wagon, V, state.links, state.x, &rate, &forces);
  for (const WagonForces::Wheel& wheel : forces.wheels)
    if (!(wheel.q > 0)) throw std::runtime_error("no running equilibrium: a wheel carries nothing");
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const double y = state.x[axle * wheelset::kSize + wheelset::kY];
    if (y < wagon.contact.y_min() || y > wagon.contact.y_max())
      throw std::runtime_error(
          "no running equilibrium: a wheelset would stand beyond the contact table, at y = " + Format(1e3 * y) + " mm");
  }
}

}  // namespace

WagonState FindEquilibrium(const Wagon& wagon, double V, EquilibriumStats* stats) {
  if (!(V > 0) || !std::isfinite(V)) throw std::invalid_argument("the speed of the wagon must be positive");
  Problem problem(wagon, V);
  const auto n = static_cast<Eigen::Index>(problem.size());
  Eigen::VectorXd residual(n), step(n);
  Eigen::MatrixXd jacobian(n, n);

  WagonState state;
  state.x = problem.MakeStart();
  EquilibriumStats found;
  for (bool converged = false; !converged;) {
    problem.Evaluate(state.x, &residual, &jacobian);
    step = jacobian.partialPivLu().solve(residual);
    if (!step.allFinite() || ++found.iterations > kMostIterations)
      throw std::runtime_error("no running equilibrium found after " + std::to_string(found.iterations) +
                               " steps of Newton's method; the largest acceleration left is " +
                               Format(residual.cwiseAbs().maxCoeff()));
    const double size = problem.SizeOf(step);
    step *= CalcShare(size);
    problem.Move(step, &state.x);
    converged = size < kSmallStep;
  }
  state.links = CalcLinks(wagon, state.x, &LinkState::AtRest);
  CheckOnTrack(wagon, V, state);

  problem.Evaluate(state.x, &residual, &jacobian);
  found.residual = residual.cwiseAbs().maxCoeff();
  if (!(found.residual < kLargestResidual))
    throw std::runtime_error("no running equilibrium: accelerations of " + Format(found.residual) + " are left");
  if (stats != nullptr) *stats = found;
  return state;
}

}  // namespace uiclink
