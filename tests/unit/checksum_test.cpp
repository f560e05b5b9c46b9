#include "data/checksum.h"

#include <gtest/gtest.h>

#include "data/input_error.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

// The examples of NIST for SHA-256 (FIPS 180-4: "abc", 448 bits; CSRC's further examples: 896 bits, a million times
// 'a') and the empty message (CAVP, SHA256ShortMsg.rsp, Len = 0).
TEST(Checksum, GivesTheExamplesOfTheStandard) {
  EXPECT_EQ(CalcSha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(CalcSha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(CalcSha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(
      CalcSha256("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrs"
                 "mnopqrstnopqrstu"),
      "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  EXPECT_EQ(CalcSha256(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Checksum, OfAFileIsThatOfItsBytes) {
  const TemporaryFolder folder;
  folder.Write("a.bin", std::string("a\0b\r\n", 5));
  EXPECT_EQ(CalcFileSha256(folder.path() / "a.bin"), CalcSha256(std::string_view("a\0b\r\n", 5)));
  EXPECT_THROW(CalcFileSha256(folder.path() / "none"), InputError);
}

}  // namespace
}  // namespace uiclink
