#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace uiclink {

/// exp(-b s) cos w s and exp(-b s) sin w s at equally spaced s: turned and shrunk from one to the next.
class DampedTurner {
 public:
  DampedTurner(double b, double w, double step) : DampedTurner(b, w, 0, step) {}
  DampedTurner(double b, double w, double s, double step) {
    const double now = b == 0 ? 1 : std::exp(-b * s), next = b == 0 ? 1 : std::exp(-b * step);
    cosine_ = now * std::cos(w * s);
    sine_ = now * std::sin(w * s);
    cos_step_ = next * std::cos(w * step);
    sin_step_ = next * std::sin(w * step);
  }
  double cosine() const { return cosine_; }
  double sine() const { return sine_; }
  void Next() {
    const double c = cosine_ * cos_step_ - sine_ * sin_step_;
    sine_ = sine_ * cos_step_ + cosine_ * sin_step_;
    cosine_ = c;
  }

 private:
  double cosine_ = 0, sine_ = 0, cos_step_ = 1, sin_step_ = 0;
};

/// The values of a closed-form arc:  y = q0 + q1 s + exp(-q5 s) (q2 cos q4 s + q3 sin q4 s).
struct DampedSwing {
  std::array<double, 6> q{};

  struct Point {
    double cosine = 1, sine = 0;   ///< exp(-q5 s) cos q4 s, exp(-q5 s) sin q4 s
    double swing = 0, turned = 0;  ///< q2 cosine + q3 sine, and a quarter of a turn later [m]
    double y = 0, v = 0;           ///< [m], [m/s]
  };

  Point At(double s) const {
    const double decay = q[5] == 0 ? 1 : std::exp(-q[5] * s);
    return At(s, decay * std::cos(q[4] * s), decay * std::sin(q[4] * s));
  }
  Point At(double s, double cosine, double sine) const {
    Point p{.cosine = cosine, .sine = sine};
    p.swing = q[2] * cosine + q[3] * sine;
    p.turned = q[3] * cosine - q[2] * sine;
    p.y = q[0] + q[1] * s + p.swing;
    p.v = q[1] + q[4] * p.turned - q[5] * p.swing;
    return p;
  }
  double Acceleration(const Point& p) const {
    return (q[5] * q[5] - q[4] * q[4]) * p.swing - 2 * q[4] * q[5] * p.turned;
  }

  /// Time until the mass that moves in direction d turns round [s].
  double FindTurning(double d) const {
    const double cosine = q[4] * q[3] - q[5] * q[2];  // v = q1 + exp() (cosine cos - sine sin)
    const double sine = q[4] * q[2] + q[5] * q[3];
    double phase = std::atan2(d * cosine, d * sine);
    if (phase <= 0) phase += 2 * std::numbers::pi;
    double s = phase / q[4];
    if (q[1] == 0) return s;
    for (int i = 0; i < 20; ++i) {  // the centre moves slowly: two or three steps
      const Point p = At(s);
      const double step = p.v / Acceleration(p);
      if (!std::isfinite(step)) break;
      s = std::max(0.0, s - std::clamp(step, -0.3 / q[4], 0.3 / q[4]));
      if (std::abs(step) < 1e-15) break;
    }
    return s;
  }

  /// When the mass, which moves in direction d up to s_end, is at y [s]; y lies between its places at 0 and s_end.
  /// @param tiny  distance that is none [m]
  double FindCrossing(double y, double d, double s_end, double tiny) const {
    // Exact for a swing that neither decays nor drifts, else where Newton starts from. Times d, so that the mirror image
    // of a motion is rounded as the motion is.
    const double share = std::clamp(d * (y - q[0]) / std::hypot(q[2], q[3]), -1.0, 1.0);
    double phase = std::atan2(d * q[3] + 0.0, d * q[2]) - std::acos(share);  // + 0: no -0 where it starts from rest
    if (phase < 0) phase += 2 * std::numbers::pi;
    double s0 = 0, s1 = s_end, s = phase / q[4];
    for (int i = 0; i < 100; ++i) {
      if (!(s > s0 && s < s1)) s = 0.5 * (s0 + s1);
      const Point p = At(s);
      const double left = d * (y - p.y);
      if (std::abs(left) <= tiny || s1 - s0 <= 4e-16 * s1) break;
      (left > 0 ? s0 : s1) = s;
      s += left / (d * p.v);
    }
    return s;
  }
};

}  // namespace uiclink
