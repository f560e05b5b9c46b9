#include "vehicle/hunting/joint_losses.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "vehicle/wagon_energy.h"

namespace uiclink {
namespace {

/// Simpson's rule over a step, as shares of its length.
constexpr std::array<double, 3> kSimpson{1.0 / 6, 4.0 / 6, 1.0 / 6};

double Sum(const std::array<double, kCorners>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// The sliding force of a joint depends on speed.
bool LimitMoves(const Link& link, std::size_t joint) {
  return link.sliders()[joint].joint && (link.law().has_strengthening || !link.law().speed_terms.empty());
}

/// Share of the lateral creep force that spin makes, by Kalker's linear forces before saturation.
double CalcSpinShare(const Wagon& wagon, const WagonForces::Wheel& force, double y) {
  const ContactCurve::Place place = wagon.contact.Find(y);
  const ContactCurve::Cubic* cubic = &wagon.contact.cubic(place.cell);
  const ContactCurve::Cubic* after = wagon.contact.after_jump(place.cell);
  // On two contacts: that which carries more.
  if (after != nullptr && ContactCurve::ShareAfter(place.t) > 0.5) cubic = after;
  const WheelContact<double> c = ContactCurve::Evaluate(*cubic, place.t);
  const double by_creepage = c.f22 * force.xi_y;
  const double by_spin = c.f23 * std::sqrt(std::max(force.q, 0.0)) * force.xi_s;
  const double both = by_creepage + by_spin;
  return both != 0 ? by_spin / both : 0;
}

/// Power of the further forces of a link on the wheelset [W]: what changes sign with v, and the rest.
struct EffectPower {
  double drag = 0, reversible = 0;
};
EffectPower CalcEffectPower(const Link& link, double d, double v) {
  EffectPower power;
  for (const ForceTerm<double>& term : link.law().forces.items()) {
    const double forward = term.force(term.p, {.t = 0, .y = d, .v = v});
    const double backward = term.force(term.p, {.t = 0, .y = d, .v = -v});
    power.drag += 0.5 * link.load() * (forward - backward) * v;
    power.reversible += 0.5 * link.load() * (forward + backward) * v;
  }
  return power;
}

}  // namespace

double LinkLosses::Sum() const { return std::accumulate(sliders.begin(), sliders.end(), viscous + drag); }

double EnergyLosses::LostInLinks() const {
  double sum = 0;
  for (const auto* links : {&longitudinal, &lateral})
    for (const LinkLosses& link : *links) sum += link.Sum();
  return sum;
}
double EnergyLosses::LostInSprings() const { return Sum(springs); }
double EnergyLosses::LostInCreep() const { return Sum(creep_longitudinal) + Sum(creep_lateral) + Sum(creep_spin); }

struct LossMeter::Moment {
  StateVector<double> x;
  WagonForces forces;
  std::array<CornerDeflection<double>, kCorners> at;
};

LossMeter::LossMeter(const Wagon& wagon, double V) : wagon_(wagon), V_(V) {
  for (std::size_t i = 0; i < kCorners; ++i) {
    sum_.longitudinal[i].sliders.resize(wagon.longitudinal[i].sliders().size());
    sum_.lateral[i].sliders.resize(wagon.lateral[i].sliders().size());
  }
}

void LossMeter::Begin(const WagonState& state) {
  last_ = state;
  sum_.t0 = sum_.t1 = state.t;
  energy_begin_ = CalcStoredEnergy(wagon_, state.x, state.links) + CalcKineticEnergy(wagon_, V_, state.x);
}

LossMeter::Moment LossMeter::Look(const LinkStates& mode, const StateVector<double>& x) const {
  Moment moment{.x = x, .forces = {}, .at = {}};
  StateVector<double> unused;
  CalcForces(wagon_, V_, mode, x, &unused, &moment.forces);
  for (std::size_t i = 0; i < kCorners; ++i) moment.at[i] = CalcDeflection(wagon_, x, i);
  return moment;
}

void LossMeter::AddPowers(const Moment& moment, double weight) {
  for (std::size_t i = 0; i < kCorners; ++i) {
    const WagonForces::Wheel& wheel = moment.forces.wheels[i];
    const double y = moment.x[AxleOf(i) * wheelset::kSize + wheelset::kY];
    const double drive = -V_ * wheel.X;
    const double creep_x = -V_ * wheel.F_x * wheel.xi_x, creep_y = -V_ * wheel.F_y * wheel.xi_y;
    const double spin = CalcSpinShare(wagon_, wheel, SideOf(i) * y) * creep_y;
    sum_.drive += weight * drive;
    sum_.creep_longitudinal[i] += weight * creep_x;
    sum_.creep_lateral[i] += weight * (creep_y - spin);
    sum_.creep_spin[i] += weight * spin;
    const double contact = CalcContactPower(wagon_, V_, moment.x, moment.forces, i).value;
    sum_.contact += weight * (contact - drive + creep_x + creep_y);
    sum_.springs[i] += weight * CalcSpringLoss(wagon_, moment.forces, moment.at[i], i);
    sum_.rotations +=
        weight * CalcCornerForce(moment.forces, i).dot(CalcSecondOrderDeflectionRate(wagon_, V_, moment.x, i));
  }
}

void LossMeter::AddLink(const Link& link, const LinkState& mode, const LinkState& after, const std::array<double, 3>& d,
                        const std::array<double, 3>& v, double h, LinkLosses* losses) {
  for (std::size_t k = 0; k < kSimpson.size(); ++k) {
    const double weight = kSimpson[k] * h;
    losses->viscous += weight * link.load() * link.law().damping * v[k] * v[k];
    const EffectPower power = CalcEffectPower(link, d[k], v[k]);
    losses->drag -= weight * power.drag;
    sum_.reversible += weight * power.reversible;
  }
  for (std::size_t j = 0; j < link.sliders().size(); ++j) {
    const double side = mode.joints[j].slides;
    const double at_end = CalcJointEnergy(link, mode, j, d[2], v[2]);
    double& lost = losses->sliders[j];
    if (side != 0 && LimitMoves(link, j)) {
      for (std::size_t k = 0; k < kSimpson.size(); ++k)
        lost += kSimpson[k] * h * link.load() * link.CalcSlidingForce(j, side, v[k]) * side * v[k];
      lost -= at_end - CalcJointEnergy(link, mode, j, d[0], v[0]);
    } else {
      lost += CalcSlipLoss(link, mode, j, d[0], d[2]);
    }
    lost += at_end - CalcJointEnergy(link, after, j, d[2], v[2]);  // a static peak that is overcome
  }
}

void LossMeter::Add(const Integrator& integrator) {
  const WagonState& now = integrator.state();
  const double begin = last_.t, h = now.t - begin;
  const LinkStates& mode = integrator.step_links();
  StateVector<double> middle;
  integrator.Interpolate(begin + 0.5 * h, &middle);
  const std::array<Moment, 3> moments{Look(mode, last_.x), Look(mode, middle), Look(mode, now.x)};
  for (std::size_t k = 0; k < moments.size(); ++k) AddPowers(moments[k], kSimpson[k] * h);
  for (std::size_t i = 0; i < kCorners; ++i) {
    std::array<double, 3> dx, vx, dy, vy;
    for (std::size_t k = 0; k < moments.size(); ++k) {
      const CornerDeflection<double>& at = moments[k].at[i];
      dx[k] = at.dx, vx[k] = at.vx, dy[k] = at.dy, vy[k] = at.vy;
    }
    AddLink(wagon_.longitudinal[i], mode.longitudinal[i], now.links.longitudinal[i], dx, vx, h, &sum_.longitudinal[i]);
    AddLink(wagon_.lateral[i], mode.lateral[i], now.links.lateral[i], dy, vy, h, &sum_.lateral[i]);
  }
  last_ = now;
  sum_.t1 = now.t;
}

EnergyLosses LossMeter::Result() const {
  EnergyLosses result = sum_;
  result.stored_change =
      CalcStoredEnergy(wagon_, last_.x, last_.links) + CalcKineticEnergy(wagon_, V_, last_.x) - energy_begin_;
  return result;
}

EnergyLosses MeasureLosses(const Wagon& wagon, double V, const WagonState& start, double duration,
                           const IntegratorOptions& options) {
  Integrator integrator(wagon, options);
  integrator.Start(V, start);
  LossMeter meter(wagon, V);
  meter.Begin(integrator.state());
  const double end = start.t + duration;
  while (integrator.state().t < end) {
    if (integrator.Step(end) == Advance::kDerailed) break;
    meter.Add(integrator);
  }
  return meter.Result();
}

// --- by name ---------------------------------------------------------------------------------------------------------

namespace {

/// What a slider is called: those of the set and its effects are counted, friction of rolling and micro-slip are named.
std::string NameSlider(const Link& link, std::size_t slider) {
  if (slider == link.rolling_slider()) return "rolling_friction";
  return link.sliders()[slider].joint ? "slider_" + std::to_string(slider + 1) : "micro_slip";
}

/// The parts of one link, by name in the order of its sliders.
std::vector<LossPart> ListLink(const Link& link, const LinkLosses& losses, const std::string& where,
                               std::size_t corner) {
  std::vector<LossPart> parts;
  for (std::size_t j = 0; j < losses.sliders.size(); ++j) {
    const std::string name = NameSlider(link, j);
    const auto same = std::ranges::find(parts, name, &LossPart::what);
    if (same != parts.end()) {
      same->lost += losses.sliders[j];
    } else {
      parts.push_back({.where = where, .what = name, .corner = corner, .lost = losses.sliders[j]});
    }
  }
  if (link.law().damping != 0)
    parts.push_back({.where = where, .what = "viscous", .corner = corner, .lost = losses.viscous});
  if (!link.law().forces.empty())
    parts.push_back({.where = where, .what = "drag", .corner = corner, .lost = losses.drag});
  return parts;
}

/// The corners of one kind after each other, kinds in the order in which they are met.
void AddGrouped(const std::vector<LossPart>& found, std::vector<LossPart>* parts) {
  std::vector<std::string> kinds;
  for (const LossPart& part : found)
    if (std::ranges::find(kinds, part.what) == kinds.end()) kinds.push_back(part.what);
  for (const std::string& kind : kinds)
    std::ranges::copy_if(found, std::back_inserter(*parts), [&](const LossPart& part) { return part.what == kind; });
}

}  // namespace

std::vector<LossPart> ListLosses(const Wagon& wagon, const EnergyLosses& losses) {
  std::vector<LossPart> parts, lateral, longitudinal;
  for (std::size_t i = 0; i < kCorners; ++i) {
    for (LossPart& part : ListLink(wagon.lateral[i], losses.lateral[i], "lateral", i)) lateral.push_back(part);
    for (LossPart& part : ListLink(wagon.longitudinal[i], losses.longitudinal[i], "longitudinal", i))
      longitudinal.push_back(part);
  }
  AddGrouped(lateral, &parts);
  AddGrouped(longitudinal, &parts);
  const auto add = [&](const char* where, const char* what, const std::array<double, kCorners>& lost) {
    for (std::size_t i = 0; i < kCorners; ++i)
      parts.push_back({.where = where, .what = what, .corner = i, .lost = lost[i]});
  };
  add("vertical", wagon.options.suspension == Suspension::kLeaf ? "leaf_friction" : "damping", losses.springs);
  add("wheel", "creep_longitudinal", losses.creep_longitudinal);
  add("wheel", "creep_lateral", losses.creep_lateral);
  add("wheel", "creep_spin", losses.creep_spin);
  return parts;
}

}  // namespace uiclink
