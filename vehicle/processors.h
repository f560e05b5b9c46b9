#pragma once

// What works on lanes (lanes.h) is compiled twice, for processors with and without vectors of four doubles, and chosen
// when the program is loaded. Both give the same numbers.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define UICLINK_FOR_EACH_PROCESSOR __attribute__((target_clones("avx2", "default")))
#else
#define UICLINK_FOR_EACH_PROCESSOR
#endif
