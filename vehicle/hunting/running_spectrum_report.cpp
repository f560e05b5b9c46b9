#include "vehicle/hunting/running_spectrum_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "reports/text_table.h"
#include "reports/wrap.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

constexpr int kColumns = 120;
constexpr std::array<const char*, kAxles> kAxleNames{"front", "rear"};

std::string Words(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
}
const char* UnitOf(std::size_t motion) { return kSpectrumTable[motion].angle ? "mrad" : "mm"; }
std::string RatioOf(const SpectralLine& line) { return fmt::format("{}:{}", line.p, line.q); }

bool HasLosses(const SpectrumRun& run) { return !run.from_file; }

// --- JSON ------------------------------------------------------------------------------------------------------------

Json LineToJson(const SpectralLine& line, const char* unit) {
  return {{"frequency_hz", line.frequency},
          {std::string("amplitude_") + unit, 1e3 * line.amplitude},
          {"ratio", line.ratio},
          {"ratio_standard_error", line.ratio_error},
          {"nearest_ratio", RatioOf(line)},
          {"slip_turns", line.slip},
          {"locking", Name(line.locking)},
          {"near_free_vibration", line.near.empty() ? Json(nullptr) : Json(line.near)}};
}

Json MotionsToJson(const RunningSpectrum& spectrum) {
  Json json = Json::object();
  for (std::size_t m = 0; m < kSpectrumMotions; ++m) {
    const MotionSpectrum& motion = spectrum.motions[m];
    Json lines = Json::array();
    for (const SpectralLine& line : motion.lines) lines.push_back(LineToJson(line, UnitOf(m)));
    json[kSpectrumTable[m].name] = {{std::string("rms_") + UnitOf(m), 1e3 * motion.rms},
                                    {std::string("mean_") + UnitOf(m), 1e3 * motion.mean},
                                    {"lines", std::move(lines)}};
  }
  return json;
}

Json BaseToJson(const RunningSpectrum& spectrum) {
  if (spectrum.base_motion.empty()) return nullptr;
  return {{"motion", spectrum.base_motion},
          {"frequency_hz", spectrum.base_hz},
          {"standard_error_hz", spectrum.base_error},
          {"periods", spectrum.periods()},
          {"chance_of_locking", spectrum.chance}};
}

Json VibrationsToJson(const std::vector<FreeVibration>& vibrations) {
  Json json = Json::array();
  for (const FreeVibration& v : vibrations) {
    json.push_back({{"motion", v.name},
                    {"joints_stuck_hz", v.stuck_hz},
                    {"joints_sliding_hz", v.sliding_hz},
                    {"real_part_1_per_s", v.decay}});
  }
  return json;
}

/// Calls take(key, use, clearance) for every axle and direction.
template <typename Take>
void ForEachGuide(const SpectrumRun& run, Take take) {
  for (std::size_t i = 0; i < kAxles; ++i)
    take(std::string(kAxleNames[i]) + "_lateral", run.uses.lateral[i], run.guidance.lateral_clearance);
  for (std::size_t i = 0; i < kAxles; ++i)
    take(std::string(kAxleNames[i]) + "_longitudinal", run.uses.longitudinal[i], run.guidance.longitudinal_clearance);
}

Json ImpactsToJson(const SpectrumRun& run) {
  Json json = Json::object();
  ForEachGuide(run, [&](const std::string& key, const GuidanceUse& use, double clearance) {
    json[key] = {{"clearance_mm", 1e3 * clearance},
                 {"least_clearance_left_mm", 1e3 * (clearance - use.clearance_used)},
                 {"count", use.impacts.count},
                 {"peak_N", use.impacts.peak_N}};
  });
  return json;
}

/// Per cycle; null at rest.
Json PerCycle(const SpectrumRun& run, double energy) {
  return run.cycles > 0 ? Json(energy / run.cycles) : Json(nullptr);
}
double ShareOf(const SpectrumRun& run, double energy) {
  const double lost = run.losses.Lost();
  return lost != 0 ? energy / lost : 0;
}

Json LossesToJson(const SpectrumRun& run) {
  if (!HasLosses(run)) return nullptr;
  Json parts = Json::array();
  for (const LossPart& part : run.loss_parts) {
    parts.push_back({{"place", part.where},
                     {"part", part.what},
                     {"corner", kCornerNames[part.corner]},
                     {"energy_J", part.lost},
                     {"per_cycle_J", PerCycle(run, part.lost)},
                     {"share", ShareOf(run, part.lost)}});
  }
  Json balance = Json::object();
  for (const BalanceLine& line : ListBalance(run.losses))
    balance[line.name] = {{"energy_J", line.energy}, {"per_cycle_J", PerCycle(run, line.energy)}};
  return {{"from_s", run.losses.t0},
          {"to_s", run.losses.t1},
          {"cycles", run.cycles > 0 ? Json(run.cycles) : Json(nullptr)},
          {"parts", std::move(parts)},
          {"balance", std::move(balance)}};
}

// --- text ------------------------------------------------------------------------------------------------------------

std::string Verdict(const SpectralLine& line) {
  std::string text = Name(line.locking);
  if (!line.near.empty()) text += ", near the free " + Words(line.near) + " vibration";
  return text;
}

std::string SpectrumText(const SpectrumRun& run) {
  const RunningSpectrum& s = run.spectrum;
  std::string text = fmt::format("{:.4g} s at {:g} samples a second", s.duration, s.hz);
  if (!run.from_file) text += fmt::format(" after {:g} s", run.settle);
  text += fmt::format("; {:.4g} Hz between lines of the spectra.\n\n", s.motions[0].power.line_hz);
  if (s.at_rest) {
    text +=
        Paragraph(fmt::format("At rest: nothing moves by more than {:g} um or urad (rms), so that there are no lines. "
                              "Below the speed at which hunting begins every start dies out; another start, a "
                              "higher speed or a shorter --settle may show motion.",
                              1e6 * kRest),
                  0, kColumns);
    return text;
  }
  text += MakeLineTable(s).Format();
  if (s.base_motion.empty()) return text + "\nNo lateral motion, so that there is no base frequency.\n";
  text += fmt::format(
      "\nBase: {} at {:.5f} Hz (standard error {:.1g} Hz), {:.1f} periods. A line anywhere would pass for locked "
      "with {:.1f} %.\n",
      Words(s.base_motion), s.base_hz, s.base_error, s.periods(), 100 * s.chance);
  if (s.periods() < kLeastPeriods)
    text += fmt::format("Too short to tell what keeps step: {:g} periods are wanted.\n", kLeastPeriods);
  return text + "\n" + MakeLockingTable(s).Format();
}

std::string VibrationText(const SpectrumRun& run) {
  return run.vibrations.empty() ? "" : "\n" + MakeVibrationTable(run).Format();
}

std::string GuidanceText(const SpectrumRun& run) {
  std::string text = "\n" + MakeGuidanceTable(run).Format();
  if (!run.inputs.choice.options.guidance) text += "(the guides are taken away: --no-guidance)\n";
  return text;
}

std::string LossText(const SpectrumRun& run) {
  if (!HasLosses(run)) return "\nLosses need a run of their own: histories do not hold them.\n";
  const EnergyLosses& losses = run.losses;
  const bool cycles = run.cycles > 0;
  const double per = cycles ? run.cycles : 1;
  std::string text =
      cycles ? fmt::format("\nEnergy lost per cycle (mean of {:g} in {:.4g} s):\n\n", per, losses.t1 - losses.t0)
             : fmt::format("\nEnergy lost in {:.4g} s:\n\n", losses.t1 - losses.t0);
  text += MakeLossTable(run).Format() + "\n";
  const double off = losses.Residual();
  text += Paragraph(
      fmt::format("The drive gives {:.5g} J{}. The motion gains {:.3g} J, the wheels' normal forces take {:.3g} J; "
                  "rotations of first order give {:.3g} J, elastic effects {:.3g} J. The balance is off by {:.2g} J, "
                  "{:.2g} % of what is lost.",
                  losses.drive / per, cycles ? " per cycle" : "", losses.stored_change / per, -losses.contact / per,
                  losses.rotations / per, losses.reversible / per, off / per, 100 * std::abs(ShareOf(run, off))),
      0, kColumns);
  const double suspension = losses.LostInLinks() + losses.LostInSprings();
  if (suspension != 0)
    text += Paragraph(
        fmt::format("Of what the suspension loses, the links' joints take {:.1f} % and the vertical springs {:.1f} %; "
                    "creep of the wheels takes {:.1f} % of all.",
                    100 * losses.LostInLinks() / suspension, 100 * losses.LostInSprings() / suspension,
                    100 * ShareOf(run, losses.LostInCreep())),
        0, kColumns);
  return text;
}

}  // namespace

TextTable MakeVibrationTable(const SpectrumRun& run) {
  TextTable table;
  table.AddColumn("free vibration", TextTable::Align::kLeft);
  table.AddColumn("joints stuck\n[Hz]");
  table.AddColumn("sliding\n[Hz]");
  table.AddColumn("real part\n[1/s]");
  for (const FreeVibration& v : run.vibrations)
    table.AddRow({Words(v.name), fmt::format("{:.3f}", v.stuck_hz), fmt::format("{:.3f}", v.sliding_hz),
                  fmt::format("{:+.3f}", v.decay)});
  return table;
}

TextTable MakeGuidanceTable(const SpectrumRun& run) {
  TextTable table;
  table.AddColumn("axle box against guide", TextTable::Align::kLeft);
  table.AddColumn("clearance\n[mm]");
  table.AddColumn("least left\n[mm]");
  table.AddColumn("impacts");
  table.AddColumn("peak\n[kN]");
  ForEachGuide(run, [&](const std::string& key, const GuidanceUse& use, double clearance) {
    table.AddRow({Words(key), fmt::format("{:.1f}", 1e3 * clearance),
                  fmt::format("{:.3f}", 1e3 * (clearance - use.clearance_used)), std::to_string(use.impacts.count),
                  use.impacts.count > 0 ? fmt::format("{:.2f}", 1e-3 * use.impacts.peak_N) : "-"});
  });
  return table;
}

TextTable MakeLossTable(const SpectrumRun& run) {
  const double per = run.cycles > 0 ? run.cycles : 1;
  TextTable table;
  table.AddColumn("lost in", TextTable::Align::kLeft);
  for (const char* corner : kCornerNames) {
    std::string head = corner;
    head.replace(head.find('_'), 1, "\n");
    table.AddColumn(head);
  }
  table.AddColumn("all\n[J]");
  table.AddColumn("share\n[%]");
  const auto add = [&](const std::string& name, const std::array<double, kCorners>& lost) {
    std::vector<std::string> row{name};
    for (const double corner : lost) row.push_back(fmt::format("{:.4g}", corner / per));
    const double sum = std::accumulate(lost.begin(), lost.end(), 0.0);
    row.push_back(fmt::format("{:.5g}", sum / per));
    row.push_back(fmt::format("{:.2f}", 100 * ShareOf(run, sum)));
    table.AddRow(row);
  };
  std::array<double, kCorners> all{};
  for (const LossSum& sum : SumLosses(run.loss_parts)) {
    add(Words(sum.where) + ": " + Words(sum.what), sum.lost);
    for (std::size_t i = 0; i < kCorners; ++i) all[i] += sum.lost[i];
  }
  table.AddRule();
  add("all", all);
  return table;
}

TextTable MakeLineTable(const RunningSpectrum& spectrum) {
  TextTable table;
  table.AddColumn("motion", TextTable::Align::kLeft);
  table.AddColumn("rms");
  table.AddColumn("unit", TextTable::Align::kLeft);
  table.AddColumn("lines [Hz]", TextTable::Align::kLeft);
  for (std::size_t m = 0; m < kSpectrumMotions; ++m) {
    std::string lines;
    for (const SpectralLine& line : spectrum.motions[m].lines)
      lines += fmt::format("{}{:.3f}", lines.empty() ? "" : ", ", line.frequency);
    table.AddRow(
        {Words(kSpectrumTable[m].name), fmt::format("{:.4f}", 1e3 * spectrum.motions[m].rms), UnitOf(m), lines});
  }
  return table;
}

TextTable MakeLockingTable(const RunningSpectrum& spectrum) {
  TextTable table;
  table.AddColumn("motion", TextTable::Align::kLeft);
  table.AddColumn("line\n[Hz]");
  table.AddColumn("amplitude\n[mm, mrad]");
  table.AddColumn("ratio\nto base");
  table.AddColumn("standard\nerror");
  table.AddColumn("nearest\nratio");
  table.AddColumn("slip\n[turns]");
  table.AddColumn("keeps step?", TextTable::Align::kLeft);
  for (std::size_t m = 0; m < kSpectrumMotions; ++m) {
    std::string name = Words(kSpectrumTable[m].name);
    for (const SpectralLine& line : spectrum.motions[m].lines) {
      table.AddRow({name, fmt::format("{:.4f}", line.frequency), fmt::format("{:.4f}", 1e3 * line.amplitude),
                    fmt::format("{:.5f}", line.ratio), fmt::format("{:.1e}", line.ratio_error), RatioOf(line),
                    fmt::format("{:+.3f}", line.slip), Verdict(line)});
      name.clear();
    }
  }
  return table;
}

double LossSum::Sum() const { return std::accumulate(lost.begin(), lost.end(), 0.0); }

std::vector<LossSum> SumLosses(const std::vector<LossPart>& parts) {
  std::vector<LossSum> sums;
  for (const LossPart& part : parts) {
    auto same = std::ranges::find_if(
        sums, [&](const LossSum& sum) { return sum.where == part.where && sum.what == part.what; });
    if (same == sums.end()) same = sums.insert(sums.end(), LossSum{.where = part.where, .what = part.what, .lost = {}});
    same->lost[part.corner] += part.lost;
  }
  return sums;
}

std::vector<BalanceLine> ListBalance(const EnergyLosses& losses) {
  return {{"drive", losses.drive},           {"contact", losses.contact}, {"rotations", losses.rotations},
          {"reversible", losses.reversible}, {"lost", losses.Lost()},     {"stored_change", losses.stored_change},
          {"residual", losses.Residual()}};
}

std::string FormatSpectrumJson(const SpectrumRun& run) {
  Json json = BeginResult("spectrum", run.inputs);
  const RunningSpectrum& s = run.spectrum;
  json["speed"] = run.V > 0 ? Json(run.V) : Json(nullptr);
  json["source"] = {{"kind", run.from_file ? "histories" : "run"}, {"from", run.source}};
  json["settle_s"] = run.from_file ? Json(nullptr) : Json(run.settle);
  json["window_s"] = s.duration;
  json["end_reason"] = run.end_reason.empty() ? Json(nullptr) : Json(run.end_reason);
  json["sampling_hz"] = s.hz;
  json["line_distance_hz"] = s.motions[0].power.line_hz;
  json["segments"] = s.segments;
  json["at_rest"] = s.at_rest;
  json["base"] = BaseToJson(s);
  json["motions"] = MotionsToJson(s);
  json["free_vibrations"] = VibrationsToJson(run.vibrations);
  json["impacts"] = ImpactsToJson(run);
  json["losses"] = LossesToJson(run);
  json["wall_s"] = run.wall_s;
  return FormatJson(json);
}

std::string FormatSpectrum(const SpectrumRun& run) {
  const WagonInputs& inputs = run.inputs;
  std::string text = inputs.data.name;
  if (run.V > 0) text += fmt::format(" at {:g} m/s", run.V);
  text += fmt::format(", cargo {}, contact {}; {}: {}\n", inputs.freight.name, inputs.table.name,
                      run.from_file ? "histories" : "start", run.source);
  text += FormatSets(inputs) + "\n" + SpectrumText(run);
  if (!run.spectrum.at_rest) text += VibrationText(run);
  text += GuidanceText(run) + LossText(run);
  if (!run.end_reason.empty()) text += Paragraph("The run ended early: " + run.end_reason, 0, kColumns);
  return text + fmt::format("{:.3g} s of computing.\n", run.wall_s);
}

std::vector<DataColumn> SpectrumColumns(const SpectrumRun& run) {
  const RunningSpectrum& s = run.spectrum;
  std::vector<DataColumn> columns{{"frequency", "Hz", {}}};
  for (std::size_t i = 0; i < s.motions[0].power.density.size(); ++i)
    columns[0].values.push_back(static_cast<double>(i) * s.motions[0].power.line_hz);
  for (std::size_t m = 0; m < kSpectrumMotions; ++m)
    columns.push_back(
        {kSpectrumTable[m].name, kSpectrumTable[m].angle ? "rad^2/Hz" : "m^2/Hz", s.motions[m].power.density});
  return columns;
}

std::string FormatLossesCsv(const SpectrumRun& run) {
  std::string text = "place,part,corner,energy_J,per_cycle_J,share\n";
  const auto per_cycle = [&](double energy) {
    return run.cycles > 0 ? fmt::format("{}", energy / run.cycles) : std::string();
  };
  for (const LossPart& part : run.loss_parts)
    text += fmt::format("{},{},{},{},{},{}\n", part.where, part.what, kCornerNames[part.corner], part.lost,
                        per_cycle(part.lost), ShareOf(run, part.lost));
  for (const BalanceLine& line : ListBalance(run.losses))
    text += fmt::format("balance,{},,{},{},\n", line.name, line.energy, per_cycle(line.energy));
  return text;
}

}  // namespace uiclink
