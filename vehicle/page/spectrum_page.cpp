// The page of `wagon spectrum`.

#include <fmt/format.h>

#include <algorithm>

#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

std::string DescribeLocking(const RunningSpectrum& spectrum) {
  std::size_t locked = 0, free = 0, undecided = 0;
  for (const MotionSpectrum& motion : spectrum.motions)
    for (const SpectralLine& line : motion.lines)
      ++(line.locking == Locking::kLocked ? locked : line.locking == Locking::kFree ? free : undecided);
  const std::size_t all = locked + free + undecided;
  if (all == 0) return "";
  return fmt::format("Of {} lines in the spectra {} keep step with it, {} do not{}.", all, locked, free,
                     undecided > 0 ? fmt::format(", of {} one cannot tell", undecided) : "");
}

std::string DescribeSpectrum(const SpectrumRun& run) {
  const std::string where = run.V > 0 ? "At " + FormatSpeedTwice(run.V) : "In " + run.source;
  const RunningSpectrum& spectrum = run.spectrum;
  if (spectrum.at_rest)
    return fmt::format("{} {} runs quietly: nothing moves.", where, DescribeLoadedWagon(run.inputs));
  if (spectrum.base_hz <= 0)
    return fmt::format("{} {} does not hunt: nothing moves to the side.", where, DescribeLoadedWagon(run.inputs));
  const EnergyLosses& losses = run.losses;
  std::string energy;
  if (!run.from_file && losses.Lost() > 0 && run.cycles > 0)
    energy = fmt::format(
        "Every cycle loses {:.0f} J: {:.0f} % in the joints of the links, {:.0f} % in the vertical "
        "springs, {:.0f} % between wheels and rails.",
        losses.Lost() / run.cycles, 100 * losses.LostInLinks() / losses.Lost(),
        100 * losses.LostInSprings() / losses.Lost(), 100 * losses.LostInCreep() / losses.Lost());
  return JoinSentences({fmt::format("{} {} hunts {:.3f} times a second ({}).", where, DescribeLoadedWagon(run.inputs),
                                    spectrum.base_hz, SpellOut(spectrum.base_motion)),
                        DescribeLocking(spectrum), energy});
}

}  // namespace

std::string ComposeSpectrumPage(const SpectrumRun& run, const PageOrigin& origin) {
  WagonBook book("Spectra: " + DescribeWagonOnRails(run.inputs), origin);
  const RunningSpectrum& spectrum = run.spectrum;
  book.Answer(JoinSentences(
      {DescribeSpectrum(run), run.end_reason.empty() ? "" : "The run ended early: " + run.end_reason + "."}));
  book.page().Paragraph(
      fmt::format("{:.4g} s at {:g} samples a second, from: {}.", spectrum.duration, spectrum.hz, run.source), "quiet");
  book.Notices(run.inputs.notices);
  book.page().Heading(2, "Spectra", "spectra");
  book.Draw("spectrum", SpectrumFigure(run), "Power against frequency; numbers are the frequencies of peaks [Hz].");
  if (!spectrum.at_rest) book.page().Table("Lines", MakeLineTable(spectrum));
  if (spectrum.base_hz > 0) {
    book.page().Heading(2, "What keeps step", "locking");
    book.page().Paragraph(
        fmt::format("Base: {} at {:.5f} Hz (standard error {:.1g} Hz), {:.1f} periods. A line anywhere "
                    "would pass for locked with {:.1f} %.",
                    SpellOut(spectrum.base_motion), spectrum.base_hz, spectrum.base_error, spectrum.periods(),
                    100 * spectrum.chance));
    book.page().Table("Lines against the base", MakeLockingTable(spectrum));
  }
  if (!spectrum.at_rest && !run.vibrations.empty())
    book.page().Table("Free vibrations of the wagon", MakeVibrationTable(run));
  book.page().Heading(2, "Impacts", "impacts");
  Figure impacts = ImpactFigure(run);
  LinkTimeAxes(&impacts);
  book.Draw("impacts", impacts,
            "Forces of the guides and use of the clearances, the last seconds; grey lines are the guides.");
  book.page().Table("Axle boxes against their guides", MakeGuidanceTable(run));
  if (!run.from_file) {
    book.page().Heading(2, "Where the energy goes", "losses");
    book.Draw("losses", LossFigure(run), "Losses: all corners together, and corner by corner.");
    book.page().Table(run.cycles > 0 ? "Energy lost per cycle [J]" : "Energy lost [J]", MakeLossTable(run));
  }
  return book.Finish(run.inputs);
}

}  // namespace uiclink
