#pragma once

#include <utility>
#include <vector>

namespace uiclink::digitise {

/// How dark a drawn line is across itself: a stripe of width w blurred by a normal distribution of deviation s,
///   share(d) = A [Phi((w/2 - d)/s) - Phi((-w/2 - d)/s)],  d the distance of a pixel from the centre line [px].
struct Profile {
  double amplitude = 1;  ///< A [-]
  double width = 2;      ///< w [px]
  double blur = 0.4;     ///< s [px]; that of a sharp line is 0.3, a pixel's own deviation

  double Reach() const { return 0.5 * width + 3.2 * blur + 0.3; }  ///< beyond it nothing is seen [px]
};

/// Share and its derivatives by the places of one or two branches of the line along a common axis through the pixel.
struct Shade {
  double share = 0;
  double by_first = 0;
  double by_second = 0;
};

/// One branch at signed distance s1.
Shade ShadeOf(const Profile& profile, double s1);
/// Two branches at s1 and s2: the union of two stripes.
Shade ShadeOf(const Profile& profile, double s1, double s2);

/// Width, blur and amplitude that fit measured pairs of |distance| and share best; medians in bins of 0.1 px count, so
/// what crosses the line here and there does not.
Profile FitProfile(const std::vector<std::pair<float, float>>& samples, const Profile& start);

}  // namespace uiclink::digitise
