#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

/// The rig: synthetic ring-down records of a UIC double-link suspension, as the experiment of 2003 would have written
/// them (thesis, chapter 4.2).
///
/// It shares no line with the solver that is later fitted to its records: fixed small steps and a return map here,
/// closed-form arcs there. SI inside; everything of the link is divided by the load M g. Equation of motion, with the
/// force of slider i on the mass T_i by differential succession (stick T_i' = -k_i y', slide T_i = -sign(y') T0i):
///
///   y''/g = -k y + sum T_i + (effects) + (push)
///
/// The effects, with equations and units, are the tables of rig/README.md, printed from EffectCatalogue() and
/// OutsideCatalogue().
namespace uiclink::rig {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// Sizes of all effects that the plain model lacks. Each default is the neutral value: nothing of the effect is left.
/// Meaning, unit and equation of each member are in EffectCatalogue() and, for the last three, OutsideCatalogue().
struct EffectSizes {
  double viscous_c = 0;
  double drag_d = 0;
  double rolling_T_r = 0, rolling_sliding_share = 1;
  double micro_k = 0, micro_y_max = 0.004, micro_count = 32;
  double extra_k = 0, extra_T0 = 0.003;
  double cubic_k3 = 0;
  double quadratic_k2 = 0;
  double stribeck_s = 0, stribeck_v_s = 0.03;
  double strengthening_b = 0;
  double friction_rate = 0;
  double asymmetry_a = 0;
  double pendulum_l = kNever;
  double clearance_gap = 0;
  double stop_k = 0, stop_position = 0.02;
  double cross_A = 0, cross_f = 1.3, cross_decay = 0.15, cross_phase = 0;
  double mode_A = 0, mode_f = 23, mode_zeta = 0.01;
  double drift_rate = 0;
  double saturation_level = kNever;
  double nonlinearity_e = 0;
  double hum_A = 0, hum_f = 50, hum_phase = 0;
  double bump_height = 0, bump_centre = 0.012, bump_width = 0.002;
  double modulation_a = 0, modulation_f = 0.4, modulation_phase = 0;
  double maxwell_k = 0, maxwell_tau = 0.3;
};

/// One parameter of an effect.
struct EffectParameter {
  const char* symbol;          ///< key in a settings file
  const char* unit;            ///< SI, "-" for none
  const char* meaning;         ///< a few words
  double EffectSizes::*value;  ///< where it is kept
  double low, high;            ///< values that make sense, both inclusive
  double example;              ///< a size that shows clearly in a record
};

/// One effect. Its first parameter is its size: at the neutral value (the default of EffectSizes) the
/// effect vanishes whatever the others are.
struct Effect {
  const char* id;
  const char* equation;
  std::vector<EffectParameter> parameters;
};

/// The effects that the program under test knows too, in a fixed order. Any number of effects act together.
const std::vector<Effect>& EffectCatalogue();

/// Effects that the rig can make and that must stay out of every catalogue: what a program says of records that hold
/// something it has never heard of can only be tested with them.
const std::vector<Effect>& OutsideCatalogue();

/// Both lists, one after the other: all that can stand under `effects` in a settings file.
std::vector<Effect> AllEffects();

/// A list of effects as the Markdown table that stands in rig/README.md.
std::string FormatEffectTable(const std::vector<Effect>& effects);

/// A spring in series with a dry-friction slider: one joint of the link.
struct Joint {
  double k = 0;        ///< stiffness [1/m], > 0
  double T0 = 0;       ///< force at which it slides [-], >= 0
  double T_start = 0;  ///< its force on the mass before the push [-], |T_start| <= T0
};

/// The link under its load, in one direction.
struct Link {
  double g = 9.82;  ///< acceleration of gravity [m/s^2] (thesis, table 2.1)
  double k = 0;     ///< main (pendulum) stiffness [1/m], > 0
  std::vector<Joint> joints;
  EffectSizes effects;
};

/// Record-to-record scatter: the links seat differently each time (thesis, figure 4.9). Relative standard deviations
/// of normal deviates, drawn for each record and each joint by itself [-].
struct Scatter {
  double k = 0;
  double joint_k = 0;
  double joint_T0 = 0;
};

/// A person who pushes at resonance and lets go before an extremum (thesis, 4.2.2). The force follows the velocity:
///   push/(M g) = P v / hypot(v, w y),  w = sqrt(g (k + sum k_i)),
/// and P is tuned for each record until the first free extremum has the size that is asked for.
struct Push {
  double rest_s = 0.45;                  ///< reading at rest before the push [s]
  int half_swings = 5;                   ///< the push ends on the way to the extremum of this number
  double first_extremum = 0.025;         ///< mean size of the first free extremum [m]
  double first_extremum_scatter = 0;     ///< its standard deviation from record to record [m]
  double release_before_extremum = 0.2;  ///< the push ends this share of a period before the extremum, in (0, 1/4)
  enum class First { kRandom, kPositive, kNegative } first = First::kRandom;  ///< side of the first free extremum
};

/// Displacement sensor, amplifier and A/D converter (thesis, 4.2.1-4.2.2).
struct Sensor {
  double noise = 1.22e-5;   ///< white Gaussian noise before the converter [m]; 0.013 mm with the quantisation
  double zero_offset = 0;   ///< mean reading at the link's zero [m]
  double zero_scatter = 0;  ///< its standard deviation from record to record [m]
  double range = 0.032;     ///< converter's range [m]: codes -2^(bits-1) .. 2^(bits-1)-1 of width 2 range/2^bits
  int bits = 12;
  double sampling_hz = 1000;  ///< of the converter [Hz]
  int keep_every = 5;         ///< samples kept, without a filter, as in 2003
};

/// Everything that a record follows from. Read from TOML by ReadSettings().
struct Settings {
  std::string name;        ///< name of the settings file, told in a record's header
  std::string direction;   ///< "lateral" or "longitudinal"
  double mass_kg = 378.2;  ///< said in the header; the motion does not depend on it, being normalised
  double duration_s = 15;  ///< of a record, rest reading and push included [s]
  int records = 10;
  std::uint64_t seed = 1;
  int steps_per_sample = 10;  ///< integrator steps for each sample of the converter
  Link link;                  ///< population means of k, k_i, T0i
  Scatter scatter;
  Push push;
  Sensor sensor;
};

/// A settings file cannot be used. what() has one line "file:line: expected ..., found ..." for each fault.
class SettingsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads a settings file; unknown keys are faults.
/// @throws SettingsError with every fault of the file.
Settings ReadSettings(const std::filesystem::path& path);

/// The text part of ReadSettings: `text` is the whole file, `file` its name for messages.
Settings ParseSettings(const std::string& text, const std::string& file);

/// What one record was made from, SI.
struct Truth {
  Link link;                  ///< of this record, scatter applied
  double rest_y = 0;          ///< displacement before the push; 0 unless a joint starts with a force [m]
  double zero_offset = 0;     ///< reading at y = 0 [m]
  double push_amplitude = 0;  ///< P, per unit load [-]
  double push_start_s = 0;
  double release_s = 0;         ///< the push ends
  double first_extremum_s = 0;  ///< first extremum of the free motion
  double first_extremum = 0;    ///< true displacement there [m]
};

/// A record as the converter gave it.
struct RigRecord {
  std::vector<double> t;     ///< [s], from 0
  std::vector<double> y_mm;  ///< readings [mm], multiples of the converter's step
  Truth truth;
};

/// Makes record number `index` (1 is the first file). The same settings and index give the same record; records of
/// different index or seed are independent, and the draws of link, push and noise do not disturb each other.
/// @throws std::invalid_argument when no push of any strength reaches the first extremum that is asked for.
RigRecord MakeRecord(const Settings& settings, int index);

/// The exact text of a record's file (DESIGN, section 3: "# key: value" lines, then time [s] and displacement [mm]).
std::string FormatRecord(const RigRecord& record, const Settings& settings, int index);

/// The truth of some records as TOML, for tests.
std::string FormatTruth(const std::vector<RigRecord>& records, const Settings& settings);

/// A free motion without push, noise or sensor: the rig's mechanics by themselves, to be checked against closed forms.
struct FreeDecay {
  struct Extremum {
    double t;  ///< [s]
    double y;  ///< [m]
  };
  std::vector<double> t;          ///< every step [s]
  std::vector<double> y;          ///< [m]
  std::vector<double> energy;     ///< kinetic + potential energy per unit load [m]
  std::vector<double> loss;       ///< energy lost since t = 0, per unit load [m]; what a modulated spring takes counts
  std::vector<Extremum> extrema;  ///< after t = 0, in order
};

/// Lets go at the extremum y0 [m], where v = 0 and every joint has been sliding outward (T_i = -sign(y0) T0i). A
/// Maxwell branch starts relaxed.
FreeDecay ReleaseFromExtremum(const Link& link, double y0, double duration_s, double step_s = 1e-4);

}  // namespace uiclink::rig
