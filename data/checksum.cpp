#include "data/checksum.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <iterator>
#include <stdexcept>

#include "data/file.h"

namespace uiclink {

std::string CalcSha256(std::string_view bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("CalcSha256: the cryptography library refuses");
  }
  std::string text;
  for (unsigned i = 0; i < size; ++i) fmt::format_to(std::back_inserter(text), "{:02x}", digest[i]);
  return text;
}

std::string CalcFileSha256(const std::filesystem::path& path) { return CalcSha256(ReadFileWhole(path)); }

}  // namespace uiclink
