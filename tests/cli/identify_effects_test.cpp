// `identify effects`: the catalogue as the registry has it.

#include <sstream>

#include "model/effect.h"
#include "tests/cli/identify_fixture.h"

namespace uiclink {
namespace {

using IdentifyEffects = IdentifyProgram;

std::vector<std::string> SplitLines(const std::string& text) {
  std::stringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST_F(IdentifyEffects, ListsEveryEffectInTheOrderOfTheRegistryWithin100Columns) {
  const ProgramResult result = Run({"effects"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  std::vector<std::string> headings, expected;
  for (const std::string& line : SplitLines(result.out)) {
    EXPECT_LE(line.size(), 100u) << line;
    EXPECT_EQ(line.find_last_not_of(' ') + 1, line.size()) << "blanks at the end: " << line;
    if (FindEffect(line) != nullptr) headings.push_back(line);
  }
  for (const Effect* effect : Effects()) expected.emplace_back(effect->id);
  EXPECT_EQ(headings, expected);
  EXPECT_EQ(List(), std::vector<std::string>{}) << "writes no file";
}

TEST_F(IdentifyEffects, TellsAllOfAnEffect) {
  const std::string out = Run({"effects"}).out;
  const auto section = [&](const std::string& id) {
    const std::size_t begin = out.find("\n" + id + "\n") + 1;
    return out.substr(begin, out.find("\n\n", begin) + 1 - begin);
  };
  EXPECT_EQ(section("pendulum_geometry"),
            "pendulum_geometry\n"
            "  missing         the pendulum's restoring force at large swing\n"
            "  acts on         stiffness\n"
            "  equation        y''/g = -k l sin(y/l) + ...  instead of -k y\n"
            "  parameters      l [m]  swinging length, above 0.02; none at inf\n"
            "  look for        softening: the frequency falls by y^2/(16 l^2), seen only where the swing is large\n"
            "  confused with   cubic_stiffness\n"
            "  separated by    the drawing of the link: a length that no link has is another softening stiffness\n");
  EXPECT_EQ(section("rig_mode"),
            "rig_mode\n"
            "  missing         a mode of beam or frame, excited at release\n"
            "  acts on         measurement\n"
            "  equation        reading of y + q,  q'' + 2 zeta w q' + w^2 q = 0,  w = 2 pi f,  q of amplitude A\n"
            "                  where the fit begins\n"
            "  parameters      A_cos [m]  cosine part where the fit begins, -0.01 to 0.01, each record its own\n"
            "                  A_sin [m]  sine part where the fit begins, -0.01 to 0.01, each record its own\n"
            "                  f [Hz]  natural frequency, 3 to 95\n"
            "                  zeta [-]  damping ratio, 0.0001 to 0.3\n"
            "  look for        a line that decays by itself, at one frequency whatever the amplitude of the link\n"
            "  confused with   mains_hum, cross_axis_motion\n"
            "  separated by    a tap on the frame, recorded by itself; another mass moves the line\n");
  EXPECT_NE(section("asymmetric_friction").find("\n  never named:    its force is that of a symmetric joint and"),
            std::string::npos)
      << section("asymmetric_friction");
}

TEST_F(IdentifyEffects, JsonHasTheWholeRegistry) {
  const ProgramResult result = Run({"effects", "--json", "-"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  const Json json = Json::parse(result.out);  // alone there
  EXPECT_EQ(json["schema"], "identify-effects/1");
  ASSERT_EQ(json["effects"].size(), Effects().size());
  for (std::size_t i = 0; i < Effects().size(); ++i) {
    const Effect& effect = *Effects()[i];
    const Json& told = json["effects"][i];
    EXPECT_EQ(told["id"], effect.id);
    EXPECT_EQ(told["equation"], effect.equation);
    EXPECT_EQ(told["acts_on"], Name(effect.acts_on));
    EXPECT_EQ(told["signature"]["loss_exponent"], effect.signature.loss_exponent);
    EXPECT_EQ(told["unseen"].is_null(), effect.unseen.empty());
    ASSERT_EQ(told["parameters"].size(), effect.parameters.size());
    for (std::size_t p = 0; p < effect.parameters.size(); ++p) {
      EXPECT_EQ(told["parameters"][p]["symbol"], effect.parameters[p].symbol);
      EXPECT_EQ(told["parameters"][p]["low"], effect.parameters[p].low);
      EXPECT_EQ(told["parameters"][p]["scope"], effect.parameters[p].scope == Scope::kRecord ? "record" : "link");
    }
  }
  EXPECT_EQ(json["effects"][0]["parameters"][0],
            Json::parse(R"({"symbol": "c", "unit": "s/m", "meaning": "damping per unit load", "low": 0.0, "high": 0.3,
                            "scope": "link"})"));
  const Json& pendulum = json["effects"][11];
  ASSERT_EQ(pendulum["id"], "pendulum_geometry");
  EXPECT_TRUE(pendulum["neutral"].is_null()) << "an infinite length";
  EXPECT_TRUE(pendulum["parameters"][0]["high"].is_null());
}

TEST_F(IdentifyEffects, JsonGoesToAFileBesideTheText) {
  const ProgramResult both = Run({"effects", "--json", "effects.json"});
  EXPECT_EQ(both.exit_code, 0);
  EXPECT_EQ(both.out, Run({"effects"}).out);
  EXPECT_EQ(Read("effects.json"), Run({"effects", "--json", "-"}).out);
  EXPECT_EQ(Run({"effects", "--quiet"}).out, "");
}

TEST_F(IdentifyEffects, HelpShowsAnExample) {
  const ProgramResult result = Run({"effects", "--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.out.find("identify effects | less\n"), std::string::npos) << result.out;
  EXPECT_NE(Run({"--help"}).out.find("  identify effects\n"), std::string::npos);
  EXPECT_EQ(Run({"effects", "--amplitude"}).exit_code, 2);
}

}  // namespace
}  // namespace uiclink
