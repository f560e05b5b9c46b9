// The page of `wagon contact`: what appendix H of the thesis shows.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/page/animation.h"
#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

const ConicityPoint* FindAmplitude(const ContactAnalysis& analysis, double amplitude) {
  const auto found = std::ranges::find_if(
      analysis.conicity, [=](const ConicityPoint& point) { return std::abs(point.amplitude - amplitude) < 1e-9; });
  return found == analysis.conicity.end() || !std::isfinite(found->equivalent) ? nullptr : &*found;
}

std::string DescribeConicity(const ContactAnalysis& analysis) {
  constexpr double kUsual = 3e-3;  // the amplitude that EN 15302 and vehicle acceptance ask for [m]
  const ConicityPoint* const usual = FindAmplitude(analysis, kUsual);
  if (usual == nullptr) return "The wheelset has no equivalent conicity at an amplitude of 3 mm.";
  std::string text = fmt::format("Swinging by 3 mm to either side, the wheelset has an equivalent conicity of {:.3f}",
                                 usual->equivalent);
  if (std::isfinite(usual->en15302))
    text += fmt::format(" ({:.3f} by EN 15302, rigid and without roll)", usual->en15302);
  if (const ConicityPoint* const centre = analysis.conicity.empty() ? nullptr : &analysis.conicity.front();
      centre != nullptr && std::isfinite(centre->equivalent))
    text += fmt::format("; near the middle it is {:.3f}", centre->equivalent);
  return text + ". The higher it is, the faster a wheelset steers back, and the lower the speed at which it hunts.";
}

std::string DescribeContact(const WagonInputs& inputs) {
  std::string text;
  if (const double play = FindFlangePlay(inputs.table); play > 0)
    text = fmt::format("The flange meets its rail after {:.1f} mm to the side.", 1e3 * play);
  if (!inputs.contact_notes) return text;
  const std::size_t jumps = inputs.contact_notes->jumps.size();
  return JoinSentences(
      {text, inputs.geometry->contact == ContactModel::kElastic
                 ? "The contact is elastic and moves without jumps."
                 : fmt::format("The point of contact jumps at {} place{} on the way.", jumps, jumps == 1 ? "" : "s")});
}

}  // namespace

std::string ComposeContactPage(const WagonInputs& inputs, const ContactAnalysis& analysis, const std::string& prefix,
                               const PageOrigin& origin) {
  WagonBook book("Contact of wheels and rails: " + inputs.table.name, origin);
  book.Answer(JoinSentences({DescribeConicity(analysis), DescribeContact(inputs)}));
  book.Notices(inputs.notices);
  book.page().Heading(2, "Conicity", "conicity-section");
  book.Draw(prefix + "conicity", ConicityFigure(inputs, analysis),
            "Difference of the rolling radii, left less right, and the equivalent conicity that follows from it.");
  book.page().Table("Equivalent conicity", MakeConicityTable(analysis));
  book.page().Heading(2, "The contact over the lateral displacement", "quantities");
  book.Draw(prefix + "quantities", ContactTableFigure(inputs),
            "Of the left wheel; to the right its flange nears the rail. Lines are broken where the contact jumps.");
  book.page().Table("Some rows of the table", MakeContactRowTable(inputs.table));
  if (inputs.contact_notes && !inputs.contact_notes->jumps.empty())
    book.page().Table("Jumps of the contact (on the wheel from the tape circle, flange negative)",
                      MakeJumpTable(*inputs.contact_notes));
  if (inputs.contact_notes && !inputs.contact_notes->two_point.empty())
    book.page().Table("Places with two points of contact that carry load", MakeTwoPointTable(inputs));
  return book.Finish(inputs);
}

}  // namespace uiclink
