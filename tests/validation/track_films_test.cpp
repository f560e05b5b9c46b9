// From films of many kinds to parameters.

#include "tests/validation/track_films.h"

#include <gtest/gtest.h>

namespace uiclink::track_films {
namespace {

class TrackLong : public testing::TestWithParam<Case> {};

TEST_P(TrackLong, ParametersFromAFilmAreThoseOfTheMotion) { Expect(GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Films, TrackLong,
    testing::Values(
        Case{.name = "clean50", .codec = "FFV1", .noise = 0, .largest_error = 0.05},
        Case{.name = "noise50", .codec = "FFV1", .noise = 4, .largest_error = 0.05},
        Case{.name = "mjpg50shaken", .codec = "MJPG", .noise = 2, .exposure = 0.5, .shakes = true},
        Case{.name = "mpeg4_50shaken", .noise = 2, .exposure = 0.5, .shakes = true},
        Case{.name = "h264_50shaken", .codec = "avc1", .noise = 2, .exposure = 0.5, .shakes = true},
        Case{.name = "h264_25shaken", .rate_hz = 25, .codec = "avc1", .noise = 2, .exposure = 0.5, .shakes = true},
        Case{.name = "h264_30open_shutter", .rate_hz = 30, .codec = "avc1", .noise = 2, .exposure = 1},
        Case{.name = "h264_120shaken", .rate_hz = 120, .codec = "avc1", .noise = 2, .exposure = 0.5, .shakes = true}),
    [](const auto& film) { return film.param.name; });

}  // namespace
}  // namespace uiclink::track_films
