#pragma once

#include <string>
#include <string_view>

namespace uiclink {

/// Text as it stands in HTML and XML, between tags and in quoted attributes: what has a meaning there is replaced, and
/// control characters, which XML forbids, are blanks; line ends and tabs stay.
std::string EscapeMarkup(std::string_view text);

/// A command line that a shell takes back word by word: words that mean more to it stand in quotes.
std::string QuoteCommand(int argc, const char* const* argv);

}  // namespace uiclink
