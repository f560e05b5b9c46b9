#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "identify/digitise/inks.h"

namespace uiclink::digitise {
namespace {

struct Named {
  std::string_view name;
  Colour bgr;
};

// As plots use them: the web's names, and Matplotlib's default cycle under the same words where they are near.
constexpr std::array kNames = {
    Named{"black", {0, 0, 0}},        Named{"grey", {128, 128, 128}},  Named{"red", {0, 0, 255}},
    Named{"red", {40, 39, 214}},      Named{"green", {0, 128, 0}},     Named{"green", {44, 160, 44}},
    Named{"green", {0, 255, 0}},      Named{"blue", {255, 0, 0}},      Named{"blue", {180, 119, 31}},
    Named{"orange", {0, 165, 255}},   Named{"orange", {14, 127, 255}}, Named{"purple", {128, 0, 128}},
    Named{"purple", {189, 103, 148}}, Named{"brown", {75, 86, 140}},   Named{"pink", {194, 119, 227}},
    Named{"magenta", {255, 0, 255}},  Named{"cyan", {255, 255, 0}},    Named{"cyan", {207, 190, 23}},
    Named{"yellow", {0, 255, 255}},   Named{"navy", {128, 0, 0}},      Named{"olive", {34, 189, 188}},
};

double Distance(const Colour& a, const Colour& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

}  // namespace

std::string ColourName(const Colour& colour) {
  const auto nearest = std::min_element(kNames.begin(), kNames.end(), [&](const Named& a, const Named& b) {
    return Distance(a.bgr, colour) < Distance(b.bgr, colour);
  });
  return fmt::format("{} (#{:02x}{:02x}{:02x})", nearest->name, std::lround(colour[2]), std::lround(colour[1]),
                     std::lround(colour[0]));
}

Colour ParseColour(const std::string& text) {
  if (text.size() == 7 && text[0] == '#') {
    unsigned rgb = 0;
    const auto [end, error] = std::from_chars(text.data() + 1, text.data() + 7, rgb, 16);
    if (error == std::errc() && end == text.data() + 7)
      return {double(rgb & 0xFF), double(rgb >> 8 & 0xFF), double(rgb >> 16)};
  }
  const std::string name = text == "gray" ? "grey" : text;
  const auto found = std::find_if(kNames.begin(), kNames.end(), [&](const Named& n) { return n.name == name; });
  if (found != kNames.end()) return found->bgr;
  throw std::invalid_argument(fmt::format(
      "expected a colour (#rrggbb, black, grey, red, green, blue, orange, purple, brown, pink, magenta, cyan, yellow, "
      "navy, olive) or the number of a curve, found \"{}\"",
      text));
}

}  // namespace uiclink::digitise
