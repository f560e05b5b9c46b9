#include "vehicle/state_file.h"

#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"

namespace uiclink {
namespace {

constexpr std::string_view kTitle = "# wagon-state/1";

std::string FormatNumber(double value) {
  char text[64];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value, std::chars_format::hex);
  return std::string(text, end);
}

/// Everything of a link's state, in a fixed order: numbers, then joint by joint p, slides, engaged.
std::string FormatLink(const Link& link, const LinkState& state) {
  std::string line;
  for (double value : {state.K, state.C, state.c, state.upper, state.lower, state.slip})
    line += FormatNumber(value) + " ";
  line += std::to_string(state.slides);
  for (bool flag : {state.touches[0], state.touches[1], state.without_rolling_friction}) line += flag ? " 1" : " 0";
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    const LinkState::Joint& joint = state.joints[i];
    line += " " + FormatNumber(joint.p) + " " + std::to_string(joint.slides) + " " + std::to_string(joint.engaged);
  }
  return line;
}

std::string LinkKey(bool longitudinal, std::size_t corner) {
  return std::string(AxleOf(corner) == 0 ? "front" : "rear") + (SideOf(corner) > 0 ? "_left_" : "_right_") +
         (longitudinal ? "longitudinal" : "lateral");
}

/// The words of one line, one after the other.
class Words {
 public:
  Words(const std::string& file, int line, const std::string& text) : file_(file), line_(line), stream_(text) {}

  double Number() {
    const std::string word = Next("a number");
    const bool negative = word.starts_with('-');
    const char* const begin = word.data() + (negative ? 1 : 0);
    const char* const end = word.data() + word.size();
    double value = 0;
    const auto [rest, error] = std::from_chars(begin, end, value, std::chars_format::hex);
    if (error != std::errc() || rest != end) Fail("a hexadecimal number", "'" + word + "'");
    return negative ? -value : value;
  }
  double FiniteNumber() {
    const double value = Number();
    if (!std::isfinite(value)) Fail("a finite number", std::to_string(value));
    return value;
  }
  /// -1, 0 or 1
  std::int8_t Direction() {
    const std::string word = Next("-1, 0 or 1");
    if (word != "-1" && word != "0" && word != "1") Fail("-1, 0 or 1", "'" + word + "'");
    return static_cast<std::int8_t>(std::stoi(word));
  }
  bool Flag() {
    const std::string word = Next("0 or 1");
    if (word != "0" && word != "1") Fail("0 or 1", "'" + word + "'");
    return word == "1";
  }
  void End() {
    std::string word;
    if (stream_ >> word) Fail("the end of the line (the joints of this wagon's link)", "'" + word + "'");
  }

 private:
  std::string Next(const std::string& expected) {
    std::string word;
    if (!(stream_ >> word)) Fail(expected, "the end of the line");
    return word;
  }
  [[noreturn]] void Fail(const std::string& expected, const std::string& found) const {
    throw InputError(file_, line_, "expected " + expected + ", found " + found);
  }

  const std::string& file_;
  int line_;
  std::istringstream stream_;
};

LinkState ParseLink(const Link& link, Words words) {
  LinkState state;
  for (double* value : {&state.K, &state.C, &state.c, &state.upper, &state.lower, &state.slip}) *value = words.Number();
  state.slides = words.Direction();
  for (std::size_t i = 0; i < 2; ++i) state.touches[i] = words.Flag();
  state.without_rolling_friction = words.Flag();
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    LinkState::Joint& joint = state.joints[i];
    joint.p = words.FiniteNumber();
    joint.slides = words.Direction();
    joint.engaged = words.Direction();
  }
  words.End();
  return state;
}

/// What a message quotes of a file that may be anything.
std::string Quote(const std::string& text) {
  std::string quoted = text.substr(0, 60);
  for (char& c : quoted) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte >= 0x7f) c = '?';
  }
  return "'" + quoted + "'";
}

/// The words of one identity that the other lacks; all of it where there are none.
std::string WordsWithout(const std::string& identity, const std::string& other) {
  std::istringstream words(identity), others(other);
  const std::set<std::string> known{std::istream_iterator<std::string>(others), {}};
  std::string lacking;
  for (std::string word; words >> word;) {
    if (!known.contains(word)) lacking += (lacking.empty() ? "" : " ") + word;
  }
  return lacking.empty() ? identity : lacking;
}

struct Entry {
  int line = 0;
  std::string value;
};

std::map<std::string, Entry> ParseEntries(std::string_view text, const std::string& file) {
  std::map<std::string, Entry> entries;
  std::istringstream stream{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.ends_with('\r')) line.pop_back();
    if (number == 1 && line != kTitle)
      throw InputError(file, 1, "expected '" + std::string(kTitle) + "', found " + Quote(line));
    if (line.empty() || line.starts_with('#')) continue;
    const std::size_t colon = line.find(": ");
    if (colon == std::string::npos) throw InputError(file, number, "expected 'key: value', found " + Quote(line));
    if (!entries.try_emplace(line.substr(0, colon), Entry{number, line.substr(colon + 2)}).second)
      throw InputError(file, number, "expected each key once, found '" + line.substr(0, colon) + "' again");
  }
  if (entries.empty()) throw InputError(file, 0, "expected the state of a wagon, found nothing");
  return entries;
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : file_(file), entries_(ParseEntries(text, file)) {}

  const Entry& Find(const std::string& key) const {
    const auto entry = entries_.find(key);
    if (entry == entries_.end()) throw InputError(file_, 0, "expected '" + key + ": ...', found no such line");
    return entry->second;
  }
  Words Open(const std::string& key) const {
    const Entry& entry = Find(key);
    return Words(file_, entry.line, entry.value);
  }
  double Number(const std::string& key) const {
    Words words = Open(key);
    const double value = words.FiniteNumber();
    words.End();
    return value;
  }

 private:
  const std::string& file_;
  std::map<std::string, Entry> entries_;
};

}  // namespace

std::string FormatState(const Wagon& wagon, const SavedState& saved) {
  std::string identity = saved.identity;
  for (char& c : identity)
    if (c == '\n' || c == '\r') c = ' ';
  std::string text = std::string(kTitle) + "\n";
  text += "identity: " + identity + "\n";
  text += "V: " + FormatNumber(saved.V) + "\n";
  text += "t: " + FormatNumber(saved.state.t) + "\n";
  for (std::size_t i = 0; i < kMaxState; ++i)
    text += std::string(kStateNames[i]) + ": " + FormatNumber(saved.state.x[i]) + "\n";
  for (bool longitudinal : {true, false}) {
    const auto& links = longitudinal ? wagon.longitudinal : wagon.lateral;
    const auto& states = longitudinal ? saved.state.links.longitudinal : saved.state.links.lateral;
    for (std::size_t i = 0; i < kCorners; ++i)
      text += LinkKey(longitudinal, i) + ": " + FormatLink(links[i], states[i]) + "\n";
  }
  return text;
}

void WriteStateFile(const std::filesystem::path& path, const Wagon& wagon, const SavedState& saved) {
  WriteFileWhole(path, FormatState(wagon, saved));
}

SavedState ReadStateFile(const std::filesystem::path& path, const Wagon& wagon, std::string_view identity) {
  return ParseState(ReadFileWhole(path), path.string(), wagon, identity);
}

SavedState ParseState(std::string_view text, const std::string& file, const Wagon& wagon, std::string_view identity) {
  const Reader reader(text, file);
  SavedState saved;
  const Entry& entry = reader.Find("identity");
  saved.identity = entry.value;
  if (!identity.empty() && saved.identity != identity)
    throw InputError(file, entry.line,
                     "expected a state of the same inputs, '" + WordsWithout(std::string(identity), saved.identity) +
                         "', found one of '" + WordsWithout(saved.identity, std::string(identity)) + "'");
  saved.V = reader.Number("V");
  if (!(saved.V > 0))
    throw InputError(file, reader.Find("V").line, "expected a positive speed, found " + std::to_string(saved.V));
  saved.state.t = reader.Number("t");
  for (std::size_t i = 0; i < kMaxState; ++i) saved.state.x[i] = reader.Number(kStateNames[i]);
  for (bool longitudinal : {true, false}) {
    const auto& links = longitudinal ? wagon.longitudinal : wagon.lateral;
    auto& states = longitudinal ? saved.state.links.longitudinal : saved.state.links.lateral;
    for (std::size_t i = 0; i < kCorners; ++i) states[i] = ParseLink(links[i], reader.Open(LinkKey(longitudinal, i)));
  }
  return saved;
}

}  // namespace uiclink
