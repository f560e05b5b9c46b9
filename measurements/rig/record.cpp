#include <fmt/core.h>

#include <algorithm>
#include <iterator>

#include "measurements/rig/dynamics.h"
#include "measurements/rig/random.h"
#include "measurements/rig/rig.h"
#include "measurements/rig/sensor.h"

namespace uiclink::rig {
namespace {

using Stream = NormalGenerator::Stream;

/// The link as it seats in record `index`: k, then k_i and T0i of each joint.
Link DrawLink(const Settings& settings, int index) {
  NormalGenerator normal(settings.seed, index, Stream::kLink);
  Link link = settings.link;
  link.k *= 1 + settings.scatter.k * normal();
  for (Joint& joint : link.joints) {
    joint.k *= 1 + settings.scatter.joint_k * normal();
    joint.T0 *= 1 + settings.scatter.joint_T0 * normal();
    joint.T_start = std::clamp(joint.T_start, -joint.T0, joint.T0);
  }
  return link;
}

double SideOf(Push::First first, NormalGenerator& normal) {
  const bool drawn_positive = normal.Uniform() < 0.5;  // drawn in any case: a fixed side keeps the other draws
  if (first == Push::First::kRandom) return drawn_positive ? 1 : -1;
  return first == Push::First::kPositive ? 1 : -1;
}

std::string FormatLink(const Link& link) {
  std::string text = fmt::format("k = {:.9g}\nsliders = [", link.k);
  for (const Joint& joint : link.joints) {
    text += fmt::format("{} {{ k = {:.9g}, T0 = {:.9g} }}", &joint == link.joints.data() ? "" : ",", joint.k, joint.T0);
  }
  return text + " ]\n";
}

std::string FormatEffects(const EffectSizes& sizes) {
  const EffectSizes neutral;
  std::string text;
  for (const Effect& effect : AllEffects()) {
    const auto size = effect.parameters.front().value;
    if (sizes.*size == neutral.*size) continue;
    text += fmt::format("effects.{} = {{", effect.id);
    for (const EffectParameter& p : effect.parameters) {
      text += fmt::format("{} {} = {:.9g}", &p == effect.parameters.data() ? "" : ",", p.symbol, sizes.*p.value);
    }
    text += " }\n";
  }
  return text;
}

}  // namespace

RigRecord MakeRecord(const Settings& settings, int index) {
  const Push& push = settings.push;
  NormalGenerator push_normal(settings.seed, index, Stream::kPush);
  const double side = SideOf(push.first, push_normal);
  const double target = push.first_extremum + push.first_extremum_scatter * push_normal();

  RigRecord record;
  Truth& truth = record.truth;
  truth.link = DrawLink(settings, index);
  const Motion motion = RunRecord(settings, truth.link, side, target);
  truth.rest_y = motion.rest_y;
  truth.push_amplitude = motion.push_amplitude;
  truth.push_start_s = motion.push_start_s;
  truth.release_s = motion.release_s;
  truth.first_extremum_s = motion.first_extremum_s;
  truth.first_extremum = motion.first_extremum;

  NormalGenerator sensor_normal(settings.seed, index, Stream::kSensor);
  truth.zero_offset = settings.sensor.zero_offset + settings.sensor.zero_scatter * sensor_normal();
  record.y_mm = Measure(motion.y, truth, settings.sensor, sensor_normal);
  record.t.reserve(record.y_mm.size());
  for (std::size_t i = 0; i < record.y_mm.size(); ++i) {
    record.t.push_back(static_cast<double>(i) * settings.sensor.keep_every / settings.sensor.sampling_hz);
  }
  return record;
}

std::string FormatRecord(const RigRecord& record, const Settings& settings, int index) {
  std::string text = fmt::format(
      "# direction: {}\n# mass_kg: {:g}\n# g: {:g}\n# sampling_hz: {:g}\n# displacement_unit: mm\n"
      "# source: synthetic, made by the rig (measurements/rig) from settings {}, seed {}, record {}; not a "
      "measurement\n",
      settings.direction, settings.mass_kg, settings.link.g, settings.sensor.sampling_hz / settings.sensor.keep_every,
      settings.name, settings.seed, index);
  text.reserve(text.size() + 20 * record.t.size());
  for (std::size_t i = 0; i < record.t.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{:.3f}\t{:.3f}\n", record.t[i], record.y_mm[i]);
  }
  return text;
}

std::string FormatTruth(const std::vector<RigRecord>& records, const Settings& settings) {
  std::string text = fmt::format("# What the records were made from. SI, links per unit load.\ndirection = \"{}\"\n",
                                 settings.direction);
  text += fmt::format("seed = {}\n", settings.seed);
  for (const RigRecord& record : records) {
    const Truth& truth = record.truth;
    text += "\n[[record]]\n" + FormatLink(truth.link) + FormatEffects(truth.link.effects);
    text += fmt::format("zero_offset = {:.9g}\nrest_y = {:.9g}\npush_amplitude = {:.9g}\npush_start_s = {:.9g}\n",
                        truth.zero_offset, truth.rest_y, truth.push_amplitude, truth.push_start_s);
    text += fmt::format("release_s = {:.9g}\nfirst_extremum_s = {:.9g}\nfirst_extremum = {:.9g}\n", truth.release_s,
                        truth.first_extremum_s, truth.first_extremum);
  }
  return text;
}

}  // namespace uiclink::rig
