#pragma once

// Films of a known link on the bench, from the film to its parameters: k, k1 and T01 against those from the motion
// itself, and the error of every sample against the truth.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "identify/identification.h"
#include "identify/record.h"
#include "identify/track/track.h"
#include "identify/write_record.h"
#include "model/event_solver.h"
#include "model/trajectory.h"
#include "tests/cli/temporary_folder.h"
#include "tests/support/film_maker.h"

namespace uiclink::track_films {

using track::Point;

inline constexpr double kMmPerPixel = 0.2;
inline constexpr double kDuration = 12;

/// Lateral link of table 4.1, let go at 30 mm.
inline Trajectory<double> Decay() {
  Oscillator<double> link;
  link.k = 4.201;
  link.Add({.k = 1.4222, .T0 = 0.014});
  Trajectory<double> run;
  Solve(link, AtExtremum(link, 0.030), kDuration + 1, &run);
  return run;
}

struct Case {
  std::string name;
  double rate_hz = 50;
  std::string codec = "mp4v";
  double noise = 1;
  double exposure = 0;  // of a step
  bool shakes = false;
  bool varies = false;         // the rate
  double largest_error = 0.2;  // promised rms [pixel]
};

/// A hand-held camera: drifting and trembling, by a few pixels and 0.2 degrees.
inline CameraShake Tremble(double t) {
  return {{2.5 * std::sin(3.1 * t) + 1.2 * std::sin(17 * t + 1), 1.8 * std::cos(2.3 * t) + 0.7 * std::sin(23 * t)},
          0.003 * std::sin(4 * t + 0.5)};
}

inline FilmSettings SettingsOf(const Case& c, const Trajectory<double>& run) {
  FilmSettings s{.width = 480, .height = 160, .rate_hz = c.rate_hz, .object_at = {240.3, 80.2}};
  s.pictures = static_cast<int>(kDuration * c.rate_hz);
  s.codec = c.codec, s.noise = c.noise, s.exposure_s = c.exposure / c.rate_hz;
  s.motion = [&run](double t) { return Point{1e3 * run.y(std::max(0.0, t)) / kMmPerPixel, 0}; };
  if (c.shakes) s.shake = Tremble;
  if (!c.varies) return s;
  double t = 0;
  for (int i = 0; i < s.pictures; ++i) {
    s.times.push_back(t);
    t += (1 + 0.3 * std::sin(0.9 * i)) / c.rate_hz;
  }
  s.times.push_back(t);
  return s;
}

/// k, k1, T01 of one record.
inline std::vector<double> Identified(const std::string& text) {
  const Identification id = Identify(Direction::kLateral, {ParseRecord(text, "lateral_film.txt")});
  if (id.CountUsed() != 1) return {};
  return {id.link.k, id.link.sliders()[0].k, id.link.sliders()[0].T0};
}

inline std::string RecordText(std::vector<double> t, std::vector<double> y, std::vector<double> uncertainty) {
  for (std::vector<double>* column : {&y, &uncertainty})
    for (double& v : *column) v *= 1e3;
  return FormatRecord({.source = "test",
                       .direction = Direction::kLateral,
                       .mass_kg = 378.2,
                       .g = kThesisGravity,
                       .t = std::move(t),
                       .y = std::move(y),
                       .uncertainty = std::move(uncertainty)});
}

/// The motion as a displacement sensor reads it: 200 Hz, noise of 0.0125 mm (the records' of chapter 4).
inline std::vector<double> IdentifiedFromMotion(const Trajectory<double>& run) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> noise(0, 1.25e-5);
  std::vector<double> t, y;
  for (int i = 0; i < kDuration * 200; ++i) t.push_back(i / 200.0), y.push_back(run.y(t.back()) + noise(random));
  return Identified(RecordText(t, y, {}));
}

struct Outcome {
  double rms = 0, said = 0;                // error and its standard deviation as the record says it [pixel]
  double films_per_second = 0;             // seconds of film a second of processor time
  std::vector<double> parameters, shares;  // and their difference from those of the motion
};

inline Outcome RunCase(const Case& c) {
  const Trajectory<double> run = Decay();
  const FilmSettings s = SettingsOf(c, run);
  TemporaryFolder folder;
  const std::filesystem::path film = folder.path() / (c.codec == "MJPG" || c.codec == "FFV1" ? "film.avi" : "film.mp4");
  MakeFilm(s, film);
  if (c.varies) {
    std::vector<double> durations;
    for (std::size_t i = 0; i + 1 < s.times.size(); ++i) durations.push_back(s.times[i + 1] - s.times[i]);
    Restamp(film, durations);
  }
  const Point at = TruePlace(s, 0);
  const track::Box roi{static_cast<int>(at.x) - 40, static_cast<int>(at.y) - 25, 80, 50};
  const std::clock_t begin = std::clock();
  const track::TrackResult result = track::TrackFilm(film, {.roi = roi, .mm_per_pixel = kMmPerPixel});
  Outcome outcome;
  outcome.films_per_second = kDuration * CLOCKS_PER_SEC / static_cast<double>(std::clock() - begin);
  for (const std::string& warning : result.warnings) ADD_FAILURE() << warning;
  const auto n = static_cast<double>(result.t.size());
  double mean = 0;
  std::vector<double> errors;
  for (std::size_t i = 0; i < result.t.size(); ++i) {
    const double t = s.times.empty() ? static_cast<double>(result.picture[i]) / s.rate_hz : s.times[result.picture[i]];
    errors.push_back(result.FramePixels(result.y[i]) - Dot(s.motion(t), result.axis));
    mean += errors.back() / n;
    outcome.said += std::pow(result.FramePixels(result.uncertainty[i]), 2) / n;
  }
  for (const double e : errors) outcome.rms += (e - mean) * (e - mean) / n;
  outcome.rms = std::sqrt(outcome.rms), outcome.said = std::sqrt(outcome.said);
  outcome.parameters = Identified(RecordText(result.t, result.y, result.uncertainty));
  const std::vector<double> truth = IdentifiedFromMotion(run);
  for (std::size_t i = 0; i < outcome.parameters.size(); ++i)
    outcome.shares.push_back(outcome.parameters[i] / truth[i] - 1);
  return outcome;
}

inline void Expect(const Case& c) {
  const Outcome o = RunCase(c);
  ASSERT_EQ(o.shares.size(), 3u) << c.name;
  fmt::print("{:<34} error {:.4f} pixel, said {:.4f}; k {:+.3f} %, k1 {:+.3f} %, T01 {:+.3f} %; {:.1f} x real time\n",
             c.name, o.rms, o.said, 100 * o.shares[0], 100 * o.shares[1], 100 * o.shares[2], o.films_per_second);
  EXPECT_LT(o.rms, c.largest_error) << c.name;
  EXPECT_GT(o.said, 0.5 * o.rms) << c.name;  // a codec's lasting errors are seen by half
  EXPECT_LT(o.said, 3 * o.rms) << c.name;    // at 25 Hz the scatter holds the motion's own bends
  for (const double share : o.shares) EXPECT_LT(std::abs(share), 0.01) << c.name;
}

}  // namespace uiclink::track_films
