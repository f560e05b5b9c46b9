// From films to parameters: two small ones; the others take minutes (track_films_test).

#include <gtest/gtest.h>

#include "tests/validation/track_films.h"

namespace uiclink::track_films {
namespace {

TEST(Track, ParametersFromAFilmAreThoseOfTheMotion) {
  Expect({.name = "50 Hz, MPEG-4, noise 1", .largest_error = 0.1});
}

TEST(Track, VariableRateDoesNotChangeThem) {
  Expect({.name = "about 50 Hz, MPEG-4, variable", .varies = true, .largest_error = 0.1});
}

}  // namespace
}  // namespace uiclink::track_films
