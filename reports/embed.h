#pragma once

#include <cstddef>
#include <string_view>

// A file copied by the assembler into the object, as it is: a string literal of 1.5 MB takes a compiler much longer,
// and one of that length is beyond what the standard asks it to accept. The object has to depend on the file, by
// OBJECT_DEPENDS.
//
//   UICLINK_EMBED(chart_script, "/path/to/chart.js");        // in the global namespace of a .cpp file
//   std::string_view script = UICLINK_EMBEDDED(chart_script);

// NOLINTBEGIN(cppcoreguidelines-macro-usage): the name of a symbol has to become a string of the assembler's
#define UICLINK_EMBED(name, file)                                                                           \
  extern "C" {                                                                                              \
  __attribute__((visibility("hidden"))) extern const char uiclink_##name##_begin[], uiclink_##name##_end[]; \
  }                                                                                                         \
  asm(".pushsection .rodata\n"                                                                              \
      "uiclink_" #name "_begin:\n.incbin \"" file "\"\nuiclink_" #name                                      \
      "_end:\n.byte 0\n"                                                                                    \
      ".popsection\n")
#define UICLINK_EMBEDDED(name) \
  std::string_view(uiclink_##name##_begin, static_cast<std::size_t>(uiclink_##name##_end - uiclink_##name##_begin))
// NOLINTEND(cppcoreguidelines-macro-usage)
