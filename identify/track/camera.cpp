#include "identify/track/camera.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace uiclink::track {
namespace {

constexpr double kLeastSeen = 0.95;     // share of the pictures in which a patch must be seen
constexpr double kLargestShare = 0.25;  // of the target's motion
constexpr double kApart = 0.3;          // a patch that moves so far against the others is no part of them [pixel]
constexpr double kTold = 2;             // a motion counts from so many of its own errors
constexpr double kTooSmall = 0.01;      // to matter [pixel]

/// Sums for the root mean square about the mean.
struct Spread {
  double n = 0, sum = 0, squares = 0;
  void Add(double v) { n += 1, sum += v, squares += v * v; }
  double Variance() const { return n > 1 ? std::max(0.0, squares / n - sum * sum / n / n) : 0; }
};

double MotionRms(const BackgroundTrack& track) {
  Spread x, y;
  for (const Sighting& s : track.sightings)
    if (s.fit) x.Add(s.fit->place.x), y.Add(s.fit->place.y);
  return std::sqrt(x.Variance() + y.Variance());
}

double ShareSeen(const BackgroundTrack& track) {
  const auto seen = std::count_if(track.sightings.begin(), track.sightings.end(),
                                  [](const Sighting& s) { return s.fit.has_value(); });
  return static_cast<double>(seen) / static_cast<double>(track.sightings.size());
}

Point CentreOf(const std::vector<const BackgroundTrack*>& tracks) {
  Point sum;
  for (const BackgroundTrack* track : tracks) sum = sum + track->box.Centre();
  return (1.0 / static_cast<double>(tracks.size())) * sum;
}

/// Weighted least squares of one picture's places: shift, and turn if asked for, about the centre.
std::optional<CameraPose> FitPose(const std::vector<const BackgroundTrack*>& tracks, std::size_t picture, Point centre,
                                  bool turns) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  int seen = 0;
  for (const BackgroundTrack* track : tracks) {
    const std::optional<PatchFit>& fit = track->sightings[picture].fit;
    if (!fit) continue;
    ++seen;
    const Point arm = track->box.Centre() - centre, moved = fit->place - track->box.Centre();
    // Floor of 0.01 pixel: no patch may outweigh all others.
    const double weight = 1 / (0.5 * (fit->covariance.xx + fit->covariance.yy) + 1e-4);
    Eigen::Matrix<double, 2, 3> rows;
    rows << 1, 0, -arm.y, 0, 1, arm.x;
    normal += weight * rows.transpose() * rows;
    right += weight * rows.transpose() * Eigen::Vector2d(moved.x, moved.y);
  }
  if (seen == 0) return std::nullopt;
  if (!turns || seen < 2) {
    normal.row(2).setZero(), normal.col(2).setZero(), normal(2, 2) = 1;
    right(2) = 0;
  }
  const Eigen::Matrix3d inverse = normal.inverse();
  const Eigen::Vector3d pose = inverse * right;
  return CameraPose{.shift = {pose(0), pose(1)},
                    .turn = pose(2),
                    .shift_covariance = {inverse(0, 0), inverse(0, 1), inverse(1, 1)},
                    .turn_variance = turns && seen >= 2 ? inverse(2, 2) : 0};
}

std::vector<std::optional<CameraPose>> FitPoses(const std::vector<const BackgroundTrack*>& tracks, Point centre,
                                                bool turns) {
  std::vector<std::optional<CameraPose>> poses;
  for (std::size_t i = 0; i < tracks.front()->sightings.size(); ++i) poses.push_back(FitPose(tracks, i, centre, turns));
  return poses;
}

/// rms about its mean of what a patch moves against the poses [pixel].
double MotionAgainst(const BackgroundTrack& track, const std::vector<std::optional<CameraPose>>& poses, Point centre) {
  Spread x, y;
  const Point arm = track.box.Centre() - centre;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::optional<PatchFit>& fit = track.sightings[i].fit;
    if (!fit || !poses[i]) continue;
    const Point moved = fit->place - track.box.Centre() - poses[i]->shift;
    x.Add(moved.x + poses[i]->turn * arm.y), y.Add(moved.y - poses[i]->turn * arm.x);
  }
  return std::sqrt(0.5 * (x.Variance() + y.Variance()));
}

/// Largest distance of a patch from the centre [pixel].
double Reach(const std::vector<const BackgroundTrack*>& tracks, Point centre) {
  double reach = 0;
  for (const BackgroundTrack* track : tracks) {
    const Point arm = track->box.Centre() - centre;
    reach = std::max(reach, std::hypot(arm.x, arm.y));
  }
  return reach;
}

/// Of the tracks, those that are seen throughout and are the quietest.
std::vector<const BackgroundTrack*> TakeQuiet(const std::vector<BackgroundTrack>& tracks, double target_rms) {
  std::vector<std::pair<double, const BackgroundTrack*>> by_motion;
  for (const BackgroundTrack& track : tracks)
    if (ShareSeen(track) >= kLeastSeen) by_motion.emplace_back(MotionRms(track), &track);
  std::sort(by_motion.begin(), by_motion.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<const BackgroundTrack*> quiet;
  for (const auto& [rms, track] : by_motion) {
    const double least = by_motion.front().first;
    // A turning camera moves patches far from its axis more than those near it.
    if (rms <= std::max(3 * least, least + 2) && rms <= kLargestShare * target_rms) quiet.push_back(track);
  }
  return quiet;
}

/// What each patch moves against the others, told by those alone [pixel].
std::vector<double> MotionsAgainstOthers(const std::vector<const BackgroundTrack*>& tracks) {
  std::vector<double> against;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    std::vector<const BackgroundTrack*> others = tracks;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const Point centre = CentreOf(others);
    against.push_back(MotionAgainst(*tracks[i], FitPoses(others, centre, others.size() > 1), centre));
  }
  return against;
}

/// Takes out one after the other the patch that moves most against the others, until they move as one.
void TakeOutStrangers(std::vector<const BackgroundTrack*>* tracks) {
  while (tracks->size() > 1) {
    const std::vector<double> against = MotionsAgainstOthers(*tracks);
    std::vector<double> sorted = against;
    std::sort(sorted.begin(), sorted.end());
    const auto worst = std::max_element(against.begin(), against.end());
    // Two alone cannot say which of them is the stranger: both stay, and their disagreement is said.
    if (*worst <= std::max(kApart, 2 * sorted[sorted.size() / 2]) || tracks->size() == 2) return;
    tracks->erase(tracks->begin() + (worst - against.begin()));
  }
}

struct Disagreement {
  double rms = 0;    ///< of one patch [pixel]
  double scale = 1;  ///< of the covariances: what the patches disagree over what they say
};

Disagreement CalcDisagreement(const std::vector<const BackgroundTrack*>& tracks,
                              const std::vector<std::optional<CameraPose>>& poses, Point centre) {
  double against = 0, said = 0, n = 0;
  for (const BackgroundTrack* track : tracks) {
    const double rms = MotionAgainst(*track, poses, centre);
    against += rms * rms;
    for (const Sighting& s : track->sightings)
      if (s.fit) said += 0.5 * (s.fit->covariance.xx + s.fit->covariance.yy) + 1e-4, n += 1;
  }
  const double patches = static_cast<double>(tracks.size()), freedom = patches > 1.5 ? (patches - 1.5) / patches : 1;
  const double variance = against / patches / freedom;
  return {.rms = std::sqrt(variance), .scale = patches > 1.5 && n > 0 ? std::max(1.0, variance / (said / n)) : 1.0};
}

void Inflate(double scale, std::vector<std::optional<CameraPose>>* poses) {
  for (std::optional<CameraPose>& pose : *poses) {
    if (!pose) continue;
    pose->shift_covariance = {scale * pose->shift_covariance.xx, scale * pose->shift_covariance.xy,
                              scale * pose->shift_covariance.yy};
    pose->turn_variance *= scale;
  }
}

/// rms of shift and turn about their means, and of their errors.
struct PoseSpread {
  double shift = 0, shift_error = 0, turn = 0, turn_error = 0;
};

PoseSpread CalcSpread(const std::vector<std::optional<CameraPose>>& poses) {
  Spread x, y, turn;
  double shift_error = 0, turn_error = 0;
  for (const std::optional<CameraPose>& pose : poses) {
    if (!pose) continue;
    x.Add(pose->shift.x), y.Add(pose->shift.y), turn.Add(pose->turn);
    shift_error += pose->shift_covariance.xx + pose->shift_covariance.yy, turn_error += pose->turn_variance;
  }
  return {.shift = std::sqrt(x.Variance() + y.Variance()),
          .shift_error = std::sqrt(shift_error / std::max(1.0, x.n)),
          .turn = std::sqrt(turn.Variance()),
          .turn_error = std::sqrt(turn_error / std::max(1.0, x.n))};
}

}  // namespace

const char* Name(CameraModel model) {
  switch (model) {
    case CameraModel::kUnknown:
      return "unknown";
    case CameraModel::kStill:
      return "still";
    case CameraModel::kShift:
      return "shift";
    case CameraModel::kShiftAndTurn:
      return "shift and turn";
  }
  return "";
}

std::optional<Point> CameraMotion::ToReference(std::size_t picture, Point place, PlaceCovariance* covariance) const {
  if (model == CameraModel::kUnknown || model == CameraModel::kStill) return place;
  const std::optional<CameraPose>& pose = poses[picture];
  if (!pose) return std::nullopt;
  const Point arm = place - centre - pose->shift;
  const double c = std::cos(pose->turn), s = std::sin(pose->turn);
  *covariance = *covariance + pose->shift_covariance +
                PlaceCovariance{.xx = arm.y * arm.y * pose->turn_variance,
                                .xy = -arm.x * arm.y * pose->turn_variance,
                                .yy = arm.x * arm.x * pose->turn_variance};
  return centre + Point{c * arm.x + s * arm.y, -s * arm.x + c * arm.y};
}

CameraMotion FitCamera(const std::vector<BackgroundTrack>& tracks, double target_rms, Point lever) {
  CameraMotion camera;
  std::vector<const BackgroundTrack*> still = TakeQuiet(tracks, target_rms);
  TakeOutStrangers(&still);
  for (const BackgroundTrack& track : tracks) {
    const bool used = std::find(still.begin(), still.end(), &track) != still.end();
    (used ? camera.used : camera.unsteady).push_back(track.box);
  }
  if (still.empty()) return camera;
  camera.centre = CentreOf(still);
  const auto fit = [&](bool turns) {
    camera.poses = FitPoses(still, camera.centre, turns);
    const Disagreement disagreement = CalcDisagreement(still, camera.poses, camera.centre);
    camera.disagreement = disagreement.rms;
    Inflate(disagreement.scale, &camera.poses);
    return CalcSpread(camera.poses);
  };
  const Point arm = lever - camera.centre;
  const double reach = std::hypot(arm.x, arm.y);
  PoseSpread spread = fit(still.size() > 1);
  // Turning is believed where the patches themselves show it, and kept where it moves the target.
  const bool turns = still.size() > 1 && spread.turn > kTold * spread.turn_error &&
                     spread.turn * std::max(reach, Reach(still, camera.centre)) > kTooSmall;
  if (!turns) spread = fit(false);
  const bool shifts = spread.shift > kTold * spread.shift_error && spread.shift > kTooSmall;
  camera.shift_rms = spread.shift;
  camera.turn_rms = spread.turn;
  camera.model = turns ? CameraModel::kShiftAndTurn : shifts ? CameraModel::kShift : CameraModel::kStill;
  return camera;
}

}  // namespace uiclink::track
