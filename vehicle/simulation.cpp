#include "vehicle/simulation.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "vehicle/watched_run.h"

namespace uiclink {

const std::array<const char*, kMotionCount> kMotionNames{"front_lateral",      "rear_lateral",      "body_lateral",
                                                         "front_longitudinal", "rear_longitudinal", "body_yaw",
                                                         "body_roll"};

const std::array<std::size_t, kMotionCount> kMotionIndex{
    wheelset::kY,      kRearWheelset + wheelset::kY, kBody + body::kY,
    wheelset::kX,      kRearWheelset + wheelset::kX, kBody + body::kPsi,
    kBody + body::kPhi};

namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

SimulationResult Simulate(Integrator& integrator, double V, const WagonState& start, const SimulationOptions& options) {
  CheckOptions(options);
  const auto begin = Clock::now();
  const IntegratorCounts before = integrator.counts();
  integrator.Start(V, start);
  WatchedRun run(integrator, options);
  while (!run.ended()) run.AfterStep(integrator.Step(run.stop_time()));
  SimulationResult result = run.Finish();
  result.counts = integrator.counts() - before;
  result.wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

SimulationResult Simulate(const Wagon& wagon, double V, const WagonState& start, const SimulationOptions& options) {
  Integrator integrator(wagon, options.integrator);
  return Simulate(integrator, V, start, options);
}

WagonState Perturb(const Wagon& wagon, const WagonState& state, const Perturbation& by) {
  WagonState moved = state;
  StateVector<double>& x = moved.x;
  const auto pose = [&](double y) {
    const ContactCurve::Place place = wagon.contact.Find(y);
    return ContactCurve::Evaluate(wagon.contact.pose_cubic(place.cell), place.t);
  };
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    double* w = &x[axle * wheelset::kSize];
    const KinematicPose<double> before = pose(w[wheelset::kY]);
    w[wheelset::kY] += axle == 0 ? by.front_y : by.rear_y;
    w[wheelset::kPsi] += axle == 0 ? by.front_psi : by.rear_psi;
    const KinematicPose<double> after = pose(w[wheelset::kY]);
    w[wheelset::kZ] += after.z - before.z;
    w[wheelset::kPhi] += after.phi - before.phi;
  }
  x[kBody + body::kY] += by.body_y;
  x[kBody + body::kPhi] += by.body_phi;
  x[kBody + body::kPsi] += by.body_psi;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerDeflection<double> d = CalcDeflection(wagon, x, i);
    moved.links.longitudinal[i].Switch(wagon.longitudinal[i], d.dx, d.vx, 0);
    moved.links.lateral[i].Switch(wagon.lateral[i], d.dy, d.vy, 0);
  }
  return moved;
}

}  // namespace uiclink
