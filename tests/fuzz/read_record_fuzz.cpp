// libFuzzer target for the reader: the first byte chooses options, the rest is the file.
//
//   cmake -S . -B build/fuzz -DCMAKE_CXX_COMPILER=clang++ -DUICLINK_BUILD_FUZZERS=ON
//   build/fuzz/bin/read_record_fuzz -max_len=4096 -max_total_time=180 NEW tests/fuzz/corpus
//
// What it finds goes to tests/fuzz/corpus, which read_record_replay_test reads on every run.

#include <cstddef>
#include <cstdint>

#include "tests/fuzz/parse.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  uiclink::fuzz::Parse(text, uiclink::fuzz::OptionsFor(data[0]));
  return 0;
}
