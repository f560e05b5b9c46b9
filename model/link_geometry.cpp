#include "model/link_geometry.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace uiclink {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

void Require(bool holds, const char* function, const char* symbol, double value, const char* unit, const char* rule) {
  if (holds) return;
  std::ostringstream message;
  message << function << ": " << symbol << " = " << value << unit << ", must be " << rule;
  throw std::invalid_argument(message.str());
}

bool IsPositive(double value) { return value > 0 && std::isfinite(value); }

void Check(const LateralLinkGeometry& g) {
  const char* const function = "CalcLateralStiffness";
  Require(IsPositive(g.r), function, "r", g.r, " m", "> 0");
  Require(g.R > g.r && std::isfinite(g.R), function, "R", g.R, " m", "> r");
  Require(g.L > 2 * g.r && std::isfinite(g.L), function, "L", g.L, " m", "> 2 r");
  Require(g.alpha >= 0 && g.alpha < std::numbers::pi / 2, function, "alpha", g.alpha, " rad", "in [0, pi/2)");
}

void Check(const LongitudinalLinkGeometry& g, const char* function) {
  const bool pins = g.link_ends == LinkEnds::kPins;
  Require(IsPositive(g.r), function, "r", g.r, " m", "> 0");
  Require(g.R > g.r && std::isfinite(g.R), function, "R", g.R, " m", "> r");
  Require(g.L > (pins ? 2 * g.r : 0) && std::isfinite(g.L), function, "L", g.L, " m", pins ? "> 2 r" : "> 0");
  Require(std::abs(g.alpha) < std::numbers::pi / 2, function, "alpha", g.alpha, " rad", "in (-pi/2, pi/2)");
  Require(IsPositive(g.beam_length), function, "beam_length", g.beam_length, " m", "> 0");
  Require(std::isfinite(g.load_height), function, "load_height", g.load_height, " m", "finite");
}

/// A rigid arm: from its start to its end runs  length (sin g, -cos g),  g = rest + weights . q  from the vertical.
/// Bodies turn by q; a line between two rolling centres turns by a fixed combination of two bodies' angles. So every
/// position in the suspension is a sum of arms, with exact derivatives of any order.
struct Arm {
  double length;
  double rest;
  VectorXd weights;
};

/// One coordinate of a point as a function of q, to second order.
struct Expansion {
  double value = 0;
  VectorXd gradient;
  MatrixXd hessian;

  explicit Expansion(Eigen::Index n) : gradient(VectorXd::Zero(n)), hessian(MatrixXd::Zero(n, n)) {}

  void Add(double factor, const Expansion& other) {
    value += factor * other.value;
    gradient += factor * other.gradient;
    hessian += factor * other.hessian;
  }
};

struct Point {
  Expansion x, z;
  explicit Point(Eigen::Index n) : x(n), z(n) {}
};

Point Expand(const std::vector<Arm>& arms, const VectorXd& q) {
  Point point(q.size());
  for (const Arm& arm : arms) {
    const double angle = arm.rest + arm.weights.dot(q);
    const double s = arm.length * std::sin(angle), c = arm.length * std::cos(angle);
    const MatrixXd square = arm.weights * arm.weights.transpose();
    point.x.value += s;
    point.x.gradient += c * arm.weights;
    point.x.hessian -= s * square;
    point.z.value -= c;
    point.z.gradient += s * arm.weights;
    point.z.hessian += c * square;
  }
  return point;
}

/// The suspension as arms. Unknowns q: for either chain its two links, then the middle pin if it turns and matters,
/// then the four contact directions if they are free; last the beam's pitch. Zero means: as at rest.
class Suspension {
 public:
  Suspension(const LongitudinalLinkGeometry& geometry, JointMotion motion)
      : geometry_(geometry),
        motion_(motion),
        middle_is_unknown_(motion == JointMotion::kRoll && geometry.middle_turns),
        per_chain_(2 + (middle_is_unknown_ ? 1 : 0) + (motion == JointMotion::kSlide ? 4 : 0)),
        left_(MakeChain(0, geometry.alpha)),
        right_(MakeChain(per_chain_, -geometry.alpha)),
        beam_{{geometry.beam_length, std::numbers::pi / 2, Unit(2 * per_chain_)}},
        load_{{-geometry.load_height, 0, Unit(2 * per_chain_)}} {
    const VectorXd rest = VectorXd::Zero(size());
    bracket_distance_ = geometry.beam_length + Expand(left_, rest).x.value - Expand(right_, rest).x.value;
  }

  Eigen::Index size() const { return 2 * per_chain_ + 1; }

  /// Position of the load from the middle between the brackets.
  Point Load(const VectorXd& q) const {
    Point load = Expand(load_, q);
    for (const auto* chain : {&left_, &right_}) {
      const Point end = Expand(*chain, q);
      load.x.Add(0.5, end.x);
      load.z.Add(0.5, end.z);
    }
    return load;
  }

  /// Gap between the right chain's end and the beam's; both coordinates vanish while the suspension hangs together.
  Point Gap(const VectorXd& q) const {
    Point gap = Expand(right_, q);
    gap.x.value += bracket_distance_;
    for (const auto* arms : {&left_, &beam_}) {
      const Point part = Expand(*arms, q);
      gap.x.Add(-1, part.x);
      gap.z.Add(-1, part.z);
    }
    return gap;
  }

 private:
  VectorXd Unit(Eigen::Index i) const { return VectorXd::Unit(size(), i); }

  /// How far the line between pin and hole centre turns. Equal arcs:  r (g - pin) = R (g - hole).
  VectorXd RollingAngle(const VectorXd& link, const VectorXd& other) const {
    const double R = geometry_.R, r = geometry_.r;
    const bool link_has_hole = geometry_.link_ends == LinkEnds::kHoles;
    return link_has_hole ? VectorXd((R * link - r * other) / (R - r)) : VectorXd((R * other - r * link) / (R - r));
  }

  /// From bracket to beam. At rest every force runs along the chain, so all contacts lie on one line, at `slope`.
  std::vector<Arm> MakeChain(Eigen::Index first, double slope) const {
    const VectorXd ground = VectorXd::Zero(size());
    const VectorXd beam = Unit(2 * per_chain_);
    const VectorXd middle = middle_is_unknown_ ? Unit(first + 2) : ground;
    const std::array<VectorXd, 2> links{Unit(first), Unit(first + 1)};
    const std::array<VectorXd, 4> neighbours{ground, middle, middle, beam};
    std::vector<Arm> arms;
    for (int joint = 0; joint < 4; ++joint) {
      const auto j = static_cast<std::size_t>(joint);
      const VectorXd& link = links[j / 2];
      if (joint % 2 == 1) arms.push_back({geometry_.L, slope, link});
      if (motion_ == JointMotion::kPivot) continue;
      const VectorXd angle =
          motion_ == JointMotion::kRoll ? RollingAngle(link, neighbours[j]) : Unit(first + 2 + joint);
      arms.push_back({geometry_.R - geometry_.r, slope, angle});
    }
    return arms;
  }

  LongitudinalLinkGeometry geometry_;
  JointMotion motion_;
  bool middle_is_unknown_;
  Eigen::Index per_chain_;
  std::vector<Arm> left_, right_, beam_, load_;
  double bracket_distance_ = 0;
};

/// Stationary points of  L(q, l) = z_load(q) - l . c(q),  c = (gap_x, gap_z, x_load - x): the least height under
/// constraints. l[2] is dz/dx, the force per unit load.
class Lagrangian {
 public:
  Lagrangian(const Suspension& suspension, double x, const VectorXd& q, const Eigen::Vector3d* multipliers) {
    const Point load = suspension.Load(q), gap = suspension.Gap(q);
    const auto n = q.size();
    jacobian_.resize(3, n);
    jacobian_ << gap.x.gradient.transpose(), gap.z.gradient.transpose(), load.x.gradient.transpose();
    // Without an estimate: least-squares multipliers, exact wherever q is an equilibrium (x = 0).
    multipliers_ = multipliers ? *multipliers
                               : Eigen::Vector3d(jacobian_.transpose().colPivHouseholderQr().solve(load.z.gradient));
    const Eigen::Vector3d& l = multipliers_;
    hessian_ = load.z.hessian - l[0] * gap.x.hessian - l[1] * gap.z.hessian - l[2] * load.x.hessian;
    residual_.resize(n + 3);
    residual_ << load.z.gradient - jacobian_.transpose() * l, gap.x.value, gap.z.value, load.x.value - x;
    MatrixXd system = MatrixXd::Zero(n + 3, n + 3);
    system.topLeftCorner(n, n) = hessian_;
    system.topRightCorner(n, 3) = -jacobian_.transpose();
    system.bottomLeftCorner(3, n) = jacobian_;
    solver_.compute(system);
    height_ = load.z.value;
  }

  const Eigen::Vector3d& multipliers() const { return multipliers_; }
  double height() const { return height_; }
  VectorXd NewtonStep() const { return solver_.solve(-residual_); }

  /// d(q, l)/dx of the equilibrium: the last constraint moves by one.
  VectorXd DerivativeByX() const { return solver_.solve(VectorXd::Unit(residual_.size(), residual_.size() - 1)); }

  /// Second-order condition: the Hessian is positive definite on all motions that the constraints allow.
  bool IsMinimum() const {
    const MatrixXd allowed = jacobian_.fullPivLu().kernel();
    return Eigen::LLT<MatrixXd>(allowed.transpose() * hessian_ * allowed).info() == Eigen::Success;
  }

 private:
  MatrixXd jacobian_, hessian_;
  VectorXd residual_;
  Eigen::Vector3d multipliers_;
  Eigen::PartialPivLU<MatrixXd> solver_;
  double height_ = 0;
};

/// Newton's method from the equilibrium nearby; false where it does not settle.
bool MoveTo(const Suspension& suspension, double x, VectorXd& q, Eigen::Vector3d& multipliers) {
  constexpr int kMostSteps = 30;
  constexpr double kSettled = 1e-13;  // rad and -: a few roundings of angles and multipliers of order 0.1 to 1
  for (int i = 0; i < kMostSteps; ++i) {
    const VectorXd step = Lagrangian(suspension, x, q, &multipliers).NewtonStep();
    if (!step.allFinite()) return false;
    q += step.head(q.size());
    multipliers += step.tail<3>();
    if (step.cwiseAbs().maxCoeff() < kSettled) return true;
  }
  return false;
}

}  // namespace

Stiffnesses CalcLateralStiffness(const LateralLinkGeometry& g) {
  Check(g);
  const double c = std::cos(g.alpha);
  const double k = 1 / (2 * g.L * c);
  const double inner = g.L - 2 * g.r;
  const double rolling = (g.L + 2 * g.r * g.r / (g.R - g.r)) / (2 * inner * inner * c);
  return {.k = k, .sum_ki = rolling - k};
}

LinkEquilibrium FindLinkEquilibrium(const LongitudinalLinkGeometry& geometry, JointMotion motion, double x) {
  Check(geometry, "FindLinkEquilibrium");
  Require(std::isfinite(x), "FindLinkEquilibrium", "x", x, " m", "finite");
  const Suspension suspension(geometry, motion);
  VectorXd q = VectorXd::Zero(suspension.size());
  const Lagrangian rest(suspension, 0, q, nullptr);  // by symmetry an equilibrium
  Eigen::Vector3d multipliers = rest.multipliers();

  // Short steps in x, because rolling turns the contacts R/(R - r) times faster than the links.
  constexpr double kLongestStep = 1e-3;
  const int steps = static_cast<int>(std::ceil(std::min(std::abs(x) / kLongestStep, 1e4)));
  LinkEquilibrium equilibrium{.x = x};
  for (int i = 1; i <= steps; ++i) {
    if (!MoveTo(suspension, x * i / steps, q, multipliers)) return equilibrium;
  }
  const Lagrangian there(suspension, x, q, &multipliers);
  equilibrium.stiffness = there.DerivativeByX()[q.size() + 2];
  if (!std::isfinite(equilibrium.stiffness)) return equilibrium;  // the load sits at its own centre of rotation
  equilibrium.status = there.IsMinimum() ? LinkEquilibrium::Status::kFound : LinkEquilibrium::Status::kNotAMinimum;
  equilibrium.height = there.height() - rest.height();
  equilibrium.force = multipliers[2];
  equilibrium.pitch = q[q.size() - 1];
  return equilibrium;
}

Stiffnesses CalcLongitudinalStiffness(const LongitudinalLinkGeometry& geometry) {
  Check(geometry, "CalcLongitudinalStiffness");
  const LinkEquilibrium sliding = FindLinkEquilibrium(geometry, JointMotion::kPivot, 0);
  const LinkEquilibrium rolling = FindLinkEquilibrium(geometry, JointMotion::kRoll, 0);
  for (const LinkEquilibrium* equilibrium : {&sliding, &rolling}) {
    const bool is_minimum = equilibrium->status == LinkEquilibrium::Status::kFound && equilibrium->stiffness > 0;
    Require(is_minimum, "CalcLongitudinalStiffness", "load_height", geometry.load_height, " m",
            "such that the suspension at rest has least potential energy");
  }
  return {.k = sliding.stiffness, .sum_ki = rolling.stiffness - sliding.stiffness};
}

}  // namespace uiclink
