#include "vehicle/contact/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace uiclink {
namespace {

constexpr double kLongestMovedPiece = 0.5e-3;  // [m] a quintic over it leaves about 1e-16 m of a curve of radius 10 mm

}  // namespace

double ProfilePoint::Curvature() const {
  const double length = std::hypot(1.0, slope);
  return second / (length * length * length);
}

ProfilePiece ProfilePiece::Polynomial(double y_begin, double y_end, double origin,
                                      std::span<const double> coefficients) {
  if (coefficients.empty() || coefficients.size() > kMaxDegree + 1) {
    throw std::invalid_argument("profile piece: a polynomial has 1 to 9 coefficients");
  }
  ProfilePiece piece(Kind::kPolynomial, y_begin, y_end);
  piece.origin_ = origin;
  piece.degree_ = static_cast<int>(coefficients.size()) - 1;
  std::copy(coefficients.begin(), coefficients.end(), piece.c_.begin());
  return piece;
}

ProfilePiece ProfilePiece::UpperArc(double y_begin, double y_end, double y_centre, double z_centre, double radius) {
  ProfilePiece piece(Kind::kArc, y_begin, y_end);
  piece.origin_ = y_centre;
  piece.c_[0] = z_centre;
  piece.radius_ = radius;
  piece.sign_ = 1;
  return piece;
}

ProfilePiece ProfilePiece::LowerArc(double y_begin, double y_end, double y_centre, double z_centre, double radius) {
  ProfilePiece piece = UpperArc(y_begin, y_end, y_centre, z_centre, radius);
  piece.sign_ = -1;
  return piece;
}

ProfilePiece ProfilePiece::Hermite(double y_begin, const ProfilePoint& begin, double y_end, const ProfilePoint& end) {
  const double h = y_end - y_begin;
  // What the quadratic through the begin misses at the end: height, slope, second derivative, made of length h.
  const double d0 = end.z - begin.z - h * (begin.slope + 0.5 * h * begin.second);
  const double d1 = h * (end.slope - begin.slope - h * begin.second);
  const double d2 = h * h * (end.second - begin.second);
  const double h3 = h * h * h;
  const std::array<double, 6> c{begin.z,
                                begin.slope,
                                0.5 * begin.second,
                                (10 * d0 - 4 * d1 + 0.5 * d2) / h3,
                                (-15 * d0 + 7 * d1 - d2) / (h3 * h),
                                (6 * d0 - 3 * d1 + 0.5 * d2) / (h3 * h * h)};
  return Polynomial(y_begin, y_end, y_begin, c);
}

ProfilePoint ProfilePiece::Eval(double y) const {
  const double u = y - origin_;
  if (kind_ == Kind::kArc) {
    const double height = std::sqrt(radius_ * radius_ - u * u);
    const double slope = -u / height;
    return {.z = c_[0] + sign_ * height + line_slope_ * u,
            .slope = sign_ * slope + line_slope_,
            .second = -sign_ * (1 + slope * slope) / height};
  }
  double z = 0;
  double slope = 0;
  double half_second = 0;
  for (int k = degree_; k >= 0; --k) {
    half_second = half_second * u + slope;
    slope = slope * u + z;
    z = z * u + c_[static_cast<std::size_t>(k)];
  }
  return {.z = z, .slope = slope, .second = 2 * half_second};
}

double ProfilePiece::CalcSlope(double y) const {
  const double u = y - origin_;
  if (kind_ == Kind::kArc) return -sign_ * u / std::sqrt(radius_ * radius_ - u * u) + line_slope_;
  double slope = 0;
  for (int k = degree_; k > 0; --k) slope = slope * u + k * c_[static_cast<std::size_t>(k)];
  return slope;
}

ProfilePiece ProfilePiece::WithLine(double at_begin, double at_end) const {
  ProfilePiece piece = *this;
  const double slope = (at_end - at_begin) / (y_end_ - y_begin_);
  piece.c_[0] += at_begin + slope * (origin_ - y_begin_);
  if (kind_ == Kind::kArc) {
    piece.line_slope_ += slope;
  } else {
    piece.c_[1] += slope;
    piece.degree_ = std::max(degree_, 1);
  }
  return piece;
}

ProfilePiece ProfilePiece::Cut(double y_begin, double y_end) const {
  ProfilePiece piece = *this;
  piece.y_begin_ = y_begin;
  piece.y_end_ = y_end;
  return piece;
}

ProfilePiece ProfilePiece::Mirrored() const {
  ProfilePiece piece = *this;
  piece.y_begin_ = -y_end_;
  piece.y_end_ = -y_begin_;
  piece.origin_ = -origin_;
  piece.line_slope_ = -line_slope_;
  if (kind_ == Kind::kPolynomial) {
    for (std::size_t k = 1; k < c_.size(); k += 2) piece.c_[k] = -c_[k];
  }
  return piece;
}

ProfilePiece ProfilePiece::Shifted(double dy, double dz) const {
  ProfilePiece piece = Cut(y_begin_ + dy, y_end_ + dy);
  piece.origin_ += dy;
  piece.c_[0] += dz;
  return piece;
}

void ProfilePiece::AppendTurned(double angle, double dy, double dz, std::vector<ProfilePiece>& pieces) const {
  const double cos = std::cos(angle);
  const double sin = std::sin(angle);
  const auto moved_y = [&](double y) { return y * cos - Eval(y).z * sin + dy; };
  if (kind_ == Kind::kArc && line_slope_ == 0) {
    ProfilePiece piece = Cut(moved_y(y_begin_), moved_y(y_end_));
    piece.origin_ = origin_ * cos - c_[0] * sin + dy;
    piece.c_[0] = origin_ * sin + c_[0] * cos + dz;
    pieces.push_back(piece);
    return;
  }
  const auto moved_point = [&](double y) {
    const ProfilePoint p = Eval(y);
    const double shrink = cos - p.slope * sin;  // d y_moved / d y
    return ProfilePoint{.z = y * sin + p.z * cos + dz,
                        .slope = (sin + p.slope * cos) / shrink,
                        .second = p.second / (shrink * shrink * shrink)};
  };
  const bool straight = kind_ == Kind::kPolynomial && degree_ <= 1;
  const int count = straight ? 1 : std::max(1, static_cast<int>(std::ceil((y_end_ - y_begin_) / kLongestMovedPiece)));
  for (int i = 0; i < count; ++i) {
    const double from = y_begin_ + (y_end_ - y_begin_) * i / count;
    const double to = i + 1 == count ? y_end_ : y_begin_ + (y_end_ - y_begin_) * (i + 1) / count;
    if (straight) {
      const ProfilePoint begin = moved_point(from);
      pieces.push_back(Polynomial(moved_y(from), moved_y(to), moved_y(from), std::array{begin.z, begin.slope}));
    } else {
      pieces.push_back(Hermite(moved_y(from), moved_point(from), moved_y(to), moved_point(to)));
    }
  }
}

Profile::Profile(std::string name, std::vector<ProfilePiece> pieces)
    : name_(std::move(name)), pieces_(std::move(pieces)) {
  if (pieces_.empty()) throw std::invalid_argument("profile " + name_ + ": has no pieces");
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (!(pieces_[i].y_begin() < pieces_[i].y_end()) || (i > 0 && pieces_[i].y_begin() != pieces_[i - 1].y_end())) {
      throw std::invalid_argument("profile " + name_ + ": its pieces do not follow each other");
    }
  }
  const std::size_t cells = 4 * pieces_.size();
  cells_per_metre_ = static_cast<double>(cells) / (y_max() - y_min());
  first_piece_.resize(cells + 1);
  std::size_t piece = 0;
  for (std::size_t cell = 0; cell <= cells; ++cell) {
    const double y = y_min() + static_cast<double>(cell) / cells_per_metre_;
    while (piece + 1 < pieces_.size() && pieces_[piece].y_end() <= y) ++piece;
    first_piece_[cell] = piece;
  }
}

std::size_t Profile::FindPiece(double y) const {
  const double cell = std::min((y - y_min()) * cells_per_metre_, static_cast<double>(first_piece_.size() - 1));
  std::size_t piece = first_piece_[static_cast<std::size_t>(cell)];
  // The cell's number may be rounded up: one step back at most.
  while (piece > 0 && y < pieces_[piece].y_begin()) --piece;
  while (piece + 1 < pieces_.size() && y >= pieces_[piece].y_end()) ++piece;
  return piece;
}

ProfilePoint Profile::Eval(double y, JointSide side) const {
  if (!Contains(y)) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    return {kNan, kNan, kNan};
  }
  std::size_t piece = FindPiece(y);
  if (side == JointSide::kBelow && piece > 0 && y == pieces_[piece].y_begin()) --piece;
  return pieces_[piece].Eval(y);
}

Profile Profile::Cut(double y_begin, double y_end) const {
  std::vector<ProfilePiece> kept;
  for (const ProfilePiece& piece : pieces_) {
    const double from = std::max(piece.y_begin(), y_begin);
    const double to = std::min(piece.y_end(), y_end);
    if (from < to) kept.push_back(piece.Cut(from, to));
  }
  return Profile(name_, std::move(kept));
}

Profile Profile::Mirrored() const {
  std::vector<ProfilePiece> mirrored;
  for (auto piece = pieces_.rbegin(); piece != pieces_.rend(); ++piece) mirrored.push_back(piece->Mirrored());
  return Profile(name_, std::move(mirrored));
}

Profile Profile::WithoutSteps() const {
  std::vector<double> half_step(pieces_.size() + 1, 0.0);  // by which the piece above begins too high
  for (std::size_t i = 1; i < pieces_.size(); ++i) {
    const double y = pieces_[i].y_begin();
    half_step[i] = 0.5 * (pieces_[i].Eval(y).z - pieces_[i - 1].Eval(y).z);
  }
  std::vector<ProfilePiece> closed;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    closed.push_back(pieces_[i].WithLine(-half_step[i], half_step[i + 1]));
  }
  return Profile(name_, std::move(closed));
}

namespace {

/// The stretch around `centre` over which `angle` leaves the curve no steeper than Profile::kSteepest.
std::pair<double, double> FindGentleStretch(const Profile& profile, double angle) {
  const double steepest = std::atan(Profile::kSteepest);
  const auto gentle = [&](double y, JointSide side) {
    return std::abs(std::atan(profile.Eval(y, side).slope) + angle) <= steepest;
  };
  const auto limit = [&](double inside, double outside) {  // bisection to rounding
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (inside + outside);
      (gentle(middle, JointSide::kAbove) ? inside : outside) = middle;
    }
    return inside;
  };
  const double centre = 0.5 * (profile.y_min() + profile.y_max());
  constexpr double kStep = 0.1e-3;
  double low = centre;
  while (low > profile.y_min()) {
    const double next = std::max(low - kStep, profile.y_min());
    if (!gentle(next, JointSide::kAbove)) {
      low = limit(low, next);
      break;
    }
    low = next;
  }
  double high = centre;
  while (high < profile.y_max()) {
    const double next = std::min(high + kStep, profile.y_max());
    if (!gentle(next, JointSide::kBelow)) {
      high = limit(high, next);
      break;
    }
    high = next;
  }
  return {low, high};
}

}  // namespace

Profile Profile::Shifted(double dy, double dz) const {
  std::vector<ProfilePiece> shifted;
  for (const ProfilePiece& piece : pieces_) shifted.push_back(piece.Shifted(dy, dz));
  return Profile(name_, std::move(shifted));
}

Profile Profile::Moved(double angle, double dy, double dz) const {
  const auto [low, high] = FindGentleStretch(*this, angle);
  const Profile gentle = Cut(low, high);
  std::vector<ProfilePiece> moved;
  for (const ProfilePiece& piece : gentle.pieces()) piece.AppendTurned(angle, dy, dz, moved);
  // Where two pieces met at one y, rounding (or a step in height) may leave their turned ends apart.
  for (std::size_t i = 1; i < moved.size(); ++i) {
    moved[i] = moved[i].Cut(moved[i - 1].y_end(), moved[i].y_end());
  }
  return Profile(name_, std::move(moved));
}

}  // namespace uiclink
